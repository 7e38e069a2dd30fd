// The connection to the server: messages both ways, as JSON.

export class Connection extends EventTarget {
  bytes = 0; // received so far

  constructor() {
    super();
    const url = new URL("socket", location.href);
    url.protocol = "ws:";
    url.search = "";
    this.socket = new WebSocket(url);
    this.socket.addEventListener("message", ({ data }) => {
      this.bytes += data.length;
      const message = JSON.parse(data);
      this.dispatchEvent(new CustomEvent(message.kind, { detail: message }));
    });
    this.socket.addEventListener("close", () => this.dispatchEvent(new Event("lost")));
  }

  send(kind, content = {}) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify({ kind, ...content }));
  }

  on(kind, handle) {
    this.addEventListener(kind, (event) => handle(event.detail));
  }
}
