// Keeps the page's files, so that it opens without a network. Another version is another cache; so is the same page below another path.
const OWN = `lumivox-studio ${registration.scope} `;
const CACHE = `${OWN}VERSION`;
const FILES = ['./', 'index.html', 'studio.css', 'studio.js', 'worker.js', 'lumivox_studio.js', 'lumivox_studio_bg.wasm', 'manifest.webmanifest', 'icon.svg'];

// From the server: what the browser has kept of them may be of the version before.
const keep = async () => (await caches.open(CACHE)).addAll(FILES.map((file) => new Request(file, { cache: 'reload' })));

oninstall = (event) => event.waitUntil(keep());

onactivate = (event) => event.waitUntil((async () => {
    for (const name of await caches.keys()) {
        if (name.startsWith(OWN) && name !== CACHE) await caches.delete(name);
    }
    await clients.claim();
})());

onfetch = (event) => {
    const { method, mode, url } = event.request;
    if (method !== 'GET' || new URL(url).origin !== location.origin) return;
    // Whatever stands behind `?`, the page is the same.
    const options = { ignoreSearch: mode === 'navigate' };
    event.respondWith(caches.open(CACHE).then(async (cache) => {
        const kept = await cache.match(event.request, options);
        if (kept) return kept;
        const answer = await fetch(event.request);
        // The program for shared pages is as large as the page: it is kept once somebody has wanted it.
        if (answer.ok && new URL(url).pathname.includes('/viewer/')) await cache.put(event.request, answer.clone());
        return answer;
    }));
};
