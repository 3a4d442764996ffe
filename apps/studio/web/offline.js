// Keeps the page's files, so that it opens without a network. Another version is another cache.
const CACHE = 'lumivox-studio-VERSION';
const FILES = ['./', 'index.html', 'studio.css', 'studio.js', 'worker.js', 'lumivox_studio.js', 'lumivox_studio_bg.wasm', 'manifest.webmanifest', 'icon.svg'];

oninstall = (event) => event.waitUntil(caches.open(CACHE).then((cache) => cache.addAll(FILES)));

onactivate = (event) => event.waitUntil((async () => {
    for (const name of await caches.keys()) {
        if (name.startsWith('lumivox-studio-') && name !== CACHE) await caches.delete(name);
    }
    await clients.claim();
})());

onfetch = (event) => {
    if (event.request.method !== 'GET' || new URL(event.request.url).origin !== location.origin) return;
    event.respondWith(caches.open(CACHE).then(async (cache) => await cache.match(event.request) ?? fetch(event.request)));
};
