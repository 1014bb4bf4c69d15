// Keeps the page's files, so that it opens without a network. `./dev web` puts the names and the version in.
const version = 'KNEAD_VERSION_OF_FILES';
const files = [KNEAD_FILES];

self.addEventListener('install', (event) => {
  event.waitUntil(caches.open(version).then((cache) => cache.addAll(files)).then(() => self.skipWaiting()));
});

self.addEventListener('activate', (event) => {
  const old = (names) => Promise.all(names.filter((name) => name !== version).map((name) => caches.delete(name)));
  event.waitUntil(caches.keys().then(old).then(() => self.clients.claim()));
});

// What threads need (serve.mjs), for servers that do not send it.
function isolated(response) {
  if (response.type !== 'basic' && response.type !== 'default') return response;
  const headers = new Headers(response.headers);
  headers.set('Cross-Origin-Opener-Policy', 'same-origin');
  headers.set('Cross-Origin-Embedder-Policy', 'require-corp');
  return new Response(response.body, { status: response.status, statusText: response.statusText, headers });
}

// What is kept is shown first: all files of a version belong together.
self.addEventListener('fetch', (event) => {
  if (event.request.method !== 'GET' || new URL(event.request.url).origin !== self.location.origin) return;
  const kept = caches.open(version).then((cache) => cache.match(event.request, { ignoreSearch: true }));
  event.respondWith(kept.then((response) => response ?? fetch(event.request)).then(isolated));
});

// The page names the program that this browser runs: one of two.
self.addEventListener('message', (event) => {
  event.waitUntil(caches.open(version).then((cache) => cache.addAll(event.data.keep)));
});
