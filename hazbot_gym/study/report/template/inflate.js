"use strict";
document.getElementById("too-old").hidden = "DecompressionStream" in window;

/** Return the text that an element holds compressed (deflate, base64). */
async function inflate(id) {
  const letters = atob(document.getElementById(id).textContent);
  const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).text();
}
