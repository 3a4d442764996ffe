// What of the page is easier said in the browser's own language: its dialogs, drops, downloads and Workers.
import start, { Page, place } from './lumivox_studio.js';

/** What was given to the page: files by their paths, as handles. Whoever needs bytes reads them from where they lie. */
const files = new Map();

/** Puts an arrival's files there, and gives the paths of what it is made of: of loose files each by itself, or all as a folder. */
function arrive(pairs, apart = false) {
    const of = (what) => pairs.map(what);
    const [before, ...tops] = place(of(([path]) => path), of(([, file]) => file.size), of(([, file]) => file.lastModified), apart);
    for (const [path, file] of pairs) files.set(before + path, file);
    return tops;
}

const EMPTY = 'there is no file in it';

/** All files of a dropped file or folder. */
async function gather(entry, path, pairs) {
    const read = (way) => new Promise(way).catch((error) => {
        throw new Error(`${path}: the browser cannot read it: ${error?.message ?? error}`);
    });
    if (entry.isFile) {
        pairs.push([path, await read((done, failed) => entry.file(done, failed))]);
        return;
    }
    const reader = entry.createReader();
    for (;;) {
        const some = await read((done, failed) => reader.readEntries(done, failed));
        if (some.length === 0) return;
        for (const inner of some) await gather(inner, `${path}/${inner.name}`, pairs);
    }
}

function say(words) {
    const told = document.getElementById('told');
    told.hidden = words === undefined;
    document.getElementById('words').textContent = words ?? '';
}

const NEEDS = 'Chrome and Edge have it (113 or newer; on Linux it may have to be switched on), Safari 26, and Firefox 141 on '
    + 'Windows. The Studio for the desktop needs no browser.';

/** A browser that has just begun, or whose GPU's process begins again, finds no graphics card for a moment. */
async function adapterOf(gpu) {
    for (let tries = 3; ; tries--) {
        const adapter = await gpu.requestAdapter({ powerPreference: 'high-performance' });
        if (adapter || tries === 0) return adapter;
        await new Promise((done) => setTimeout(done, 400));
    }
}

/** Why there can be no picture, in words; nothing where there can. */
async function obstacle() {
    if (!window.isSecureContext) return 'Browsers give WebGPU only to pages that come by https or from this machine (127.0.0.1).';
    if (!navigator.gpu) return `This browser has no WebGPU, by which the Studio computes pictures. ${NEEDS}`;
    const adapter = await adapterOf(navigator.gpu);
    if (!adapter) return `This browser has WebGPU, but finds no graphics card for it, or does not trust its driver. ${NEEDS}`;
    const { vendor = '', architecture = '', description = '' } = adapter.info ?? {};
    return { software: adapter.info?.isFallbackAdapter || /swiftshader|llvmpipe|basic render/i.test(`${vendor} ${architecture} ${description}`) };
}

async function compiled() {
    return WebAssembly.compile(await fetched('lumivox_studio_bg.wasm'));
}

/** A dialog's files, or what a folder of one is made of. */
function choose(folder, apart) {
    return new Promise((done) => {
        const input = document.createElement('input');
        input.type = 'file';
        input.multiple = true;
        input.webkitdirectory = folder;
        input.onchange = () => {
            const pairs = [...input.files].map((file) => [file.webkitRelativePath || file.name, file]);
            if (pairs.length === 0) window.studio.fail(`The folder: ${EMPTY}`);
            done(arrive(pairs, apart));
        };
        input.oncancel = () => done([]);
        input.click();
    });
}

function save(name, bytes) {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(new Blob([bytes]));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

/** One of the page's own files. */
async function fetched(name) {
    const answer = await fetch(name).catch((error) => { throw new Error(`${name}: ${error.message}`); });
    if (!answer.ok) throw new Error(`${name}: ${answer.status} ${answer.statusText}`);
    return answer.arrayBuffer();
}

function worker(module) {
    return (letter, bytes, told) => {
        const own = new Worker(new URL('worker.js', import.meta.url), { type: 'module' });
        let isOver = false;
        const hear = (letter, bytes) => {
            if (isOver) return;
            isOver = letter === null || letter === '';
            if (isOver) own.terminate();
            told(letter, bytes);
        };
        own.onmessage = ({ data: [letter, bytes] }) => hear(letter, bytes);
        own.onerror = own.onmessageerror = () => hear(null, []);
        try {
            own.postMessage({ module, letter, bytes, files: [...files] }, bytes.map((part) => part.buffer));
        } catch (error) {
            // Too much for the browser, perhaps. Whoever asked hears of it once it has asked.
            console.error(error);
            setTimeout(() => hear(null, []), 0);
        }
        return () => {
            isOver = true;
            own.terminate();
        };
    };
}

/** What a drop is made of. */
async function dropped(entries) {
    const pairs = [];
    for (const entry of entries) {
        if (entry instanceof File) pairs.push([entry.name, entry]);
        else if (entry) await gather(entry, entry.name, pairs);
    }
    // Words that are dragged here are no files, and nothing is said of them.
    if (pairs.length === 0 && entries.length > 0) throw new Error(`${entries[0]?.name ?? 'The drop'}: ${EMPTY}`);
    return pairs;
}

/** Before the interface hears of it, which would read all of it into memory, and no folders. */
function takeDrops(canvas, page) {
    window.addEventListener('drop', async (event) => {
        event.preventDefault();
        event.stopImmediatePropagation();
        canvas.dispatchEvent(new DragEvent('dragleave', { bubbles: true }));
        const entries = [...event.dataTransfer.items].filter((item) => item.kind === 'file')
            .map((item) => item.webkitGetAsEntry() ?? item.getAsFile());
        try {
            const pairs = await dropped(entries);
            if (pairs.length > 0) page.bring(arrive(pairs));
        } catch (error) {
            page.fail(error.message);
        }
    }, { capture: true });
    window.addEventListener('dragover', (event) => event.preventDefault(), { capture: true });
}

/** A program that breaks leaves a picture that nothing moves any more: better words. */
function tellBreaks(page) {
    const look = (error) => {
        const why = page.broken ?? (error instanceof WebAssembly.RuntimeError ? error.message : undefined);
        if (why !== undefined) say(`The Studio broke, and has to be loaded again; what was not saved is lost. (${why})`);
    };
    window.addEventListener('error', ({ error }) => look(error));
    window.addEventListener('unhandledrejection', ({ reason }) => look(reason));
}

async function run() {
    const found = await obstacle();
    if (typeof found === 'string') return say(found);
    const canvas = document.getElementById('canvas');
    const module = await compiled();
    await start({ module_or_path: module });
    const hooks = { choose, save, fetch: fetched, work: worker(module) };
    const page = await Page.open(canvas, hooks, found.software);
    takeDrops(canvas, page);
    tellBreaks(page);
    window.addEventListener('beforeunload', (event) => {
        if (page.hasWork) event.preventDefault();
    });
    window.studio = page;
    say();
    canvas.focus();
    // A head for whoever has no scan: `#phantom`, or `#phantom=96` for one of so many voxels along each axis.
    const phantom = /^#phantom(?:=(\d+))?$/.exec(location.hash);
    if (phantom) page.phantom(Math.min(Math.max(Number(phantom[1] ?? 128), 16), 256));
    if ('serviceWorker' in navigator) await navigator.serviceWorker.register('offline.js').catch(() => {});
}

run().catch((error) => {
    console.error(error);
    say(`The Studio did not start: ${error?.message ?? error}`);
});
