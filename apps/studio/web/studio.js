// What of the page is easier said in the browser's own language: its dialogs, drops, downloads and Workers.
import start, { Page } from './lumivox_studio.js';

/** What was given to the page: files by their paths, as handles. Whoever needs bytes reads them from where they lie. */
const files = new Map();
let arrivals = 0;

/** Puts an arrival's files there, and gives the paths of what it is made of. Two files of one path are told from each other by
 * a folder around the later arrival, so that what belongs together stays together. */
function arrive(pairs, tops) {
    arrivals += 1;
    const taken = new Set([...files.keys()].map((path) => path.split('/')[0]));
    const folder = tops.some((top) => taken.has(top)) ? `${arrivals}/` : '';
    for (const [path, file] of pairs) files.set(folder + path, file);
    return tops.map((top) => folder + top);
}

/** All files of a dropped file or folder. */
async function gather(entry, path, pairs) {
    if (entry.isFile) {
        pairs.push([path, await new Promise((done, failed) => entry.file(done, failed))]);
        return;
    }
    const reader = entry.createReader();
    for (;;) {
        const some = await new Promise((done, failed) => reader.readEntries(done, failed));
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

/** Why there can be no picture, in words; nothing where there can. */
async function obstacle() {
    if (!window.isSecureContext) return 'Browsers give WebGPU only to pages that come by https or from this machine (127.0.0.1).';
    if (!navigator.gpu) return `This browser has no WebGPU, by which the Studio computes pictures. ${NEEDS}`;
    const adapter = await navigator.gpu.requestAdapter({ powerPreference: 'high-performance' });
    if (!adapter) return `This browser has WebGPU, but finds no graphics card for it, or does not trust its driver. ${NEEDS}`;
    const { vendor = '', architecture = '', description = '' } = adapter.info ?? {};
    return { software: adapter.info?.isFallbackAdapter || /swiftshader|llvmpipe|basic render/i.test(`${vendor} ${architecture} ${description}`) };
}

async function compiled() {
    const answer = await fetch('lumivox_studio_bg.wasm');
    if (!answer.ok) throw new Error(`lumivox_studio_bg.wasm: ${answer.status}`);
    return WebAssembly.compile(await answer.arrayBuffer());
}

/** A dialog's files. */
function choose(folder) {
    return new Promise((done) => {
        const input = document.createElement('input');
        input.type = 'file';
        input.multiple = true;
        input.webkitdirectory = folder;
        input.onchange = () => {
            const pairs = [...input.files].map((file) => [file.webkitRelativePath || file.name, file]);
            done(arrive(pairs, [...new Set(pairs.map(([path]) => path.split('/')[0]))]));
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
        own.onerror = () => hear(null, []);
        own.postMessage({ module, letter, bytes, files: [...files] }, bytes.map((part) => part.buffer));
        return () => {
            isOver = true;
            own.terminate();
        };
    };
}

/** Before the interface hears of it, which would read all of it into memory, and no folders. */
function takeDrops(canvas, page) {
    window.addEventListener('drop', async (event) => {
        event.preventDefault();
        event.stopImmediatePropagation();
        canvas.dispatchEvent(new DragEvent('dragleave', { bubbles: true }));
        const entries = [...event.dataTransfer.items].filter((item) => item.kind === 'file')
            .map((item) => item.webkitGetAsEntry() ?? item.getAsFile());
        const pairs = [];
        for (const entry of entries) {
            if (entry instanceof File) pairs.push([entry.name, entry]);
            else if (entry) await gather(entry, entry.name, pairs);
        }
        if (pairs.length > 0) page.bring(arrive(pairs, [...new Set(pairs.map(([path]) => path.split('/')[0]))]));
    }, { capture: true });
    window.addEventListener('dragover', (event) => event.preventDefault(), { capture: true });
}

async function run() {
    const found = await obstacle();
    if (typeof found === 'string') return say(found);
    const canvas = document.getElementById('canvas');
    const module = await compiled();
    await start({ module_or_path: module });
    const hooks = { choose, save, work: worker(module), turn: () => new Promise((done) => setTimeout(done, 0)) };
    const page = await Page.open(canvas, hooks, found.software);
    takeDrops(canvas, page);
    window.addEventListener('beforeunload', (event) => {
        if (page.isChanged) event.preventDefault();
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
