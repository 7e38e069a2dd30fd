"use strict";
document.getElementById("too-old").hidden = "DecompressionStream" in window;

/** Return the text that an element holds compressed, in base64. */
async function inflate(id, format = "deflate") {
  const letters = atob(document.getElementById(id).textContent);
  const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream(format));
  return new Response(stream).text();
}
