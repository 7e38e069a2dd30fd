// A link to a run: its settings in the address, without those that are as usual.

const USUAL = { env: "Corridor-v1", seed: 0, episode: 0, policy: "fuzzy_expert", ghost: "", tier: "tracks",
  width_m: null, people: null, unyielding: null, noise: 1, latency: 0, price: null };
const WORDS = new Set(["env", "policy", "ghost", "tier"]);

export const usual = () => ({ ...USUAL });

/** Return the settings of an address; what it does not know is left out. */
export function settingsOf(search) {
  const settings = usual();
  for (const [name, value] of new URLSearchParams(search)) {
    if (name in USUAL) settings[name] = WORDS.has(name) ? value : Number(value);
  }
  return settings;
}

/** Return the part of an address that holds some settings. */
export function searchOf(settings) {
  const unusual = Object.entries(settings).filter(([name, value]) => value !== null && value !== USUAL[name]);
  const text = new URLSearchParams(unusual).toString();
  return text ? `?${text}` : "";
}
