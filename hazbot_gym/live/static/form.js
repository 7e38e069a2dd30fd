// The choices of the page: place, driver, ghost, and the sliders of the scene.

import { usual } from "./link.js";

const WORDS = ["env", "policy", "ghost", "tier"];
const SLIDERS = ["width_m", "people", "unyielding", "noise", "latency", "price"];
const YOU = "you";
const EXPERT = "fuzzy_expert"; // drives where a policy needs gas and there is none

const $ = (id) => document.getElementById(id);
const option = ({ name, label, about }) => Object.assign(new Option(label, name), { title: about });

export class Form {
  /** `change` is called with the settings that were changed. */
  constructor({ places, policies, rates }, change) {
    [this.places, this.policies] = [places, policies];
    $("env").replaceChildren(...places.map(option));
    $("rate").replaceChildren(...rates.map((value) => new Option(`${value}×`, value, value === 1, value === 1)));
    for (const name of WORDS) {
      $(name).addEventListener("change", () => change(name === "env" ? this.placeChanges() : { [name]: $(name).value }));
    }
    for (const name of SLIDERS) {
      $(name).addEventListener("input", () => this.showOutput(name));
      $(name).addEventListener("change", () => change({ [name]: Number($(name).value) }));
    }
    $("own").addEventListener("click", () => {
      const all = usual();
      change(Object.fromEntries(SLIDERS.map((name) => [name, all[name]])));
    });
  }

  /** Return the changes for another place: from its first episode, without what it does not have. */
  placeChanges() {
    const place = this.places.find(({ name }) => name === $("env").value);
    const changes = { env: place.name, episode: 0, ...(place.width_m === null ? { width_m: null } : {}) };
    const needsGas = (policy) => this.policies.some(({ name, has_gas: isForGas }) => name === policy && isForGas);
    if (!place.has_gas && needsGas(this.settings.policy)) changes.policy = EXPERT;
    if (!place.has_gas && needsGas(this.settings.ghost)) changes.ghost = "";
    return changes;
  }

  show(settings, decision) {
    [this.settings, this.decision] = [settings, decision];
    this.place = this.places.find(({ name }) => name === settings.env);
    const fitting = this.policies.filter(({ has_gas: needsGas }) => this.place.has_gas || !needsGas);
    $("policy").replaceChildren(...fitting.map(option));
    $("ghost").replaceChildren(new Option("none", ""), ...fitting.filter(({ name }) => name !== YOU).map(option));
    for (const name of WORDS) $(name).value = settings[name];
    const prices = this.prices();
    $("price").disabled = !prices;
    if (prices) [$("price").min, $("price").max] = prices;
    for (const name of SLIDERS) {
      $(name).value = settings[name] ?? this.ownValue(name);
      this.showOutput(name);
    }
    $("width_m").disabled = this.place.width_m === null;
  }

  /** Return the least, most and usual price that the driver, or else the ghost, can be set to, or null. */
  prices() {
    const { policy, ghost } = this.settings;
    const of = (spec) => this.policies.find(({ name }) => name === spec)?.prices;
    return of(policy) ?? of(ghost) ?? null;
  }

  /** Return where a slider stands while its setting is the place's own. */
  ownValue(name) {
    const { width_m: width, people, unyielding } = this.place;
    return { width_m: width, people: Math.round((people[0] + people[1]) / 2), unyielding, noise: 1, latency: 0,
      price: this.prices()?.[2] }[name];
  }

  showOutput(name) {
    const value = Number($(name).value);
    const { people, width_m: width } = this.place;
    const isOwn = this.settings[name] === null && value === this.ownValue(name);
    const texts = {
      width_m: width === null ? "–" : `${value.toFixed(1)} m`,
      people: isOwn && people[0] !== people[1] ? `${people[0]} to ${people[1]}` : `${value}`,
      unyielding: `${Math.round(100 * value)} %`,
      noise: `${value} ×`,
      latency: `${(value * this.decision).toFixed(1)} s`,
      price: this.prices() ? `${value} s/s` : "–",
    };
    document.querySelector(`output[for=${name}]`).textContent = texts[name];
  }
}
