// Path-traced CT and MR scans on a canvas. Types and what each does are in lumivox.d.ts, which editors show.
import start, { Canvas, Scan as Voxels, presets as known } from './lumivox_wasm.js';

const NEEDS = 'Chrome and Edge have it (113 or newer; on Linux it may have to be switched on), Safari 26, and Firefox 141 on Windows.';

let loading;
let module;

/** Loads the program once, from beside this file or from where it is told. */
export function load(from) {
    loading ??= (async () => {
        // Where this file is a blob, nothing is beside it.
        from ??= new URL('lumivox_wasm_bg.wasm', import.meta.url);
        module = from instanceof WebAssembly.Module ? from : await compiled(from);
        await start({ module_or_path: module });
    })().catch((error) => {
        // It may be tried again.
        loading = undefined;
        throw error;
    });
    return loading;
}

async function compiled(from) {
    if (from instanceof ArrayBuffer) return WebAssembly.compile(from);
    // Chromium compiles no DataView.
    if (ArrayBuffer.isView(from)) return WebAssembly.compile(new Uint8Array(from.buffer, from.byteOffset, from.byteLength));
    const answer = await fetch(from);
    if (!answer.ok) throw new Error(`${from}: ${answer.status} ${answer.statusText}`);
    return WebAssembly.compile(await answer.arrayBuffer());
}

/** Why there can be no picture, in words; empty where there can. */
export async function obstacle() {
    return (await gpu()).obstacle;
}

async function gpu() {
    if (!globalThis.isSecureContext) return { obstacle: 'Browsers give WebGPU only to pages that come by https or from this machine (127.0.0.1).' };
    if (!navigator.gpu) return { obstacle: `This browser has no WebGPU. ${NEEDS}` };
    const adapter = await adapterOf(navigator.gpu);
    if (!adapter) return { obstacle: `This browser has WebGPU, but finds no graphics card for it, or does not trust its driver. ${NEEDS}` };
    const { vendor = '', architecture = '', description = '', isFallbackAdapter } = adapter.info ?? {};
    const words = `${vendor} ${architecture} ${description}`;
    return { obstacle: '', software: Boolean(isFallbackAdapter) || /swiftshader|llvmpipe|basic render/i.test(words) };
}

/** A browser that has just begun, or whose GPU's process begins again, finds no graphics card for a moment. */
async function adapterOf(gpu) {
    for (let tries = 3; ; tries--) {
        const adapter = await gpu.requestAdapter({ powerPreference: 'high-performance' });
        if (adapter || tries === 0) return adapter;
        await new Promise((done) => setTimeout(done, 400));
    }
}

/** The looks there are. */
export async function presets() {
    await load();
    return JSON.parse(known()).map(([name, description]) => ({ name, description }));
}

/** Voxels with their place in the patient. */
export class Scan {
    #voxels;

    constructor(voxels, description) {
        if (!module) throw new Error('await load() comes first');
        this.#voxels = voxels instanceof Voxels ? voxels : new Voxels(voxels, JSON.stringify(description ?? {}));
        this.series = [];
        this.notes = [];
    }

    /** A head that nobody has. */
    static async phantom(size = 128) {
        await load();
        return new Scan(Voxels.phantom(size));
    }

    get dims() { return [...this.#voxels.dims]; }
    get valueRange() { return [...this.#voxels.valueRange]; }
    get unit() { return this.#voxels.unit; }
    get preset() { return this.#voxels.preset; }

    setLabels(voxels, names) {
        this.#voxels.setLabels(voxels, JSON.stringify(names));
        return this;
    }

    setDepth(depth) {
        this.#voxels.setDepth(depth.#voxels);
        return this;
    }

    /** Gives its memory back. Views that show it keep what they need. */
    free() { this.#voxels.free(); }

    /** @internal A share of it, which whoever gets it takes. */
    _share() { return this.#voxels.share(); }
}

/** Reads files in a Worker; nothing leaves this machine. */
export async function readScan(files, { series, phase, keep = 'patient', preset, onprogress, signal } = {}) {
    await load();
    const pairs = [...files].map((file) => {
        if (Array.isArray(file)) return file;
        return [file.webkitRelativePath || file.name, file];
    });
    if (pairs.length === 0) throw new Error('there is no file to read');
    const worker = new Worker(new URL('worker.js', import.meta.url), { type: 'module' });
    try {
        const read = await new Promise((done, failed) => {
            signal?.throwIfAborted();
            signal?.addEventListener('abort', () => failed(signal.reason), { once: true });
            worker.onmessage = ({ data }) => {
                if (data.stage !== undefined) onprogress?.(data);
                else if (data.failed !== undefined) failed(new Error(data.failed));
                else done(data);
            };
            worker.onerror = (event) => failed(new Error(event.message || 'the Worker that reads broke'));
            worker.onmessageerror = () => failed(new Error('the browser has no memory for the scan'));
            worker.postMessage({ module, pairs, wanted: JSON.stringify({ series, phase, keep, preset }) });
        });
        const scan = new Scan(read.voxels, JSON.parse(read.description));
        scan.series = JSON.parse(read.series);
        scan.notes = JSON.parse(read.notes);
        return scan;
    } finally {
        worker.terminate();
    }
}

/** A view of scans on a canvas. Events: `progress`, `camera`, `error`. */
export class View extends EventTarget {
    #canvas;
    #element;
    #callOff;
    #follower;
    #controls = new AbortController();
    #isOver = false;

    constructor(canvas, element) {
        super();
        this.#canvas = canvas;
        this.#element = element;
    }

    static async create(element, { samples = 512, controls = true, mouse = 'ohif', resize = true } = {}) {
        const found = await gpu();
        if (found.obstacle) throw new Error(found.obstacle);
        await load();
        const view = new View(await Canvas.open(element, found.software), element);
        view.samples = samples;
        view.mouse = mouse;
        if (typeof HTMLCanvasElement !== 'undefined' && element instanceof HTMLCanvasElement) {
            if (resize) view.#followSize();
            if (controls) view.#listen();
        }
        return view;
    }

    /** Shows scans, in a scene document where one is given. */
    show(scans, scene = {}) {
        const all = Array.isArray(scans) ? scans : [scans];
        this.#canvas.show(written(scene), all.map((scan) => scan._share()));
        this.#wake();
    }

    get scene() {
        const text = this.#canvas.scene;
        return text === '' ? null : JSON.parse(text);
    }

    set scene(scene) {
        this.#canvas.change(written(scene));
        this.#wake();
    }

    /** The first scan's look. */
    get preset() { return this.scene?.volumes[0]?.look.preset ?? null; }

    set preset(preset) {
        const scene = this.scene;
        if (scene === null) throw new Error('nothing is shown yet');
        scene.volumes[0].look = { preset };
        this.scene = scene;
    }

    set samples(samples) {
        this.#canvas.samples = samples;
        this.#wake();
    }

    set mouse(name) { this.#canvas.mouse = name; }

    get gpu() { return this.#canvas.gpu; }

    /** Shows nothing any more. */
    clear() {
        this.#canvas.clear();
        const { width, height } = this.#element;
        // A canvas of another size is empty.
        this.#canvas.resize(width, height);
    }

    resize(width, height) {
        this.#canvas.resize(width, height);
        this.#wake();
    }

    look({ azimuth, elevation, zoom } = {}) {
        this.#canvas.look(azimuth, elevation, zoom);
        this.#moved();
    }

    /** As dragging with the first button does: parts of the view's height. */
    turn(right, down) {
        if (this.#canvas.drag(0, false, false, right, down)) this.#moved();
    }

    /** Comes closer by so many notches of a wheel. */
    zoom(notches) {
        if (this.#canvas.wheel(notches)) this.#moved();
    }

    /** What is seen at a point of the view, in parts of its width and height. */
    pick(x, y) {
        const told = this.#canvas.pick(x, y);
        return told === '' ? null : JSON.parse(told);
    }

    /** Resolves when the picture is done. */
    rest() {
        return new Promise((done, failed) => {
            const stop = new AbortController();
            const { signal } = stop;
            this.addEventListener('progress', ({ detail }) => {
                if (detail.rests) stop.abort(done(detail));
            }, { signal });
            this.addEventListener('error', ({ error }) => stop.abort(failed(error)), { signal });
            this.#wake();
        });
    }

    /** What is seen now, as a file. */
    async picture(type = 'image/png', quality) {
        // Browsers keep what a GPU drew no longer than the turn in which it was drawn.
        this.#draw();
        if (this.#element.convertToBlob) return this.#element.convertToBlob({ type, quality });
        return new Promise((done, failed) => {
            this.#element.toBlob((blob) => blob ? done(blob) : failed(new Error(`the browser makes no ${type}`)), type, quality);
        });
    }

    /** Ends it, and frees the GPU's memory. */
    destroy() {
        if (this.#isOver) return;
        this.#isOver = true;
        this.#callOff?.();
        this.#follower?.disconnect();
        this.#controls.abort();
        this.#canvas.free();
    }

    #moved() {
        this.dispatchEvent(new Event('camera'));
        this.#wake();
    }

    /** Asks for a frame, unless one is on its way. */
    #wake() {
        if (this.#callOff || this.#isOver) return;
        this.#callOff = soon(() => {
            this.#callOff = undefined;
            const told = this.#draw();
            if (told && !told.rests) this.#wake();
        });
    }

    #draw() {
        try {
            const told = this.#canvas.frame();
            const { samples, part, isShown, rests } = told;
            told.free();
            const detail = { samples, part, isShown, rests };
            this.dispatchEvent(new CustomEvent('progress', { detail }));
            return detail;
        } catch (error) {
            const told = new Event('error');
            told.error = error;
            // Who listens to none hears of it as of any other.
            if (this.dispatchEvent(told) && !this.#hears) console.error(error);
            return undefined;
        }
    }

    #hears = false;

    addEventListener(kind, ...rest) {
        this.#hears ||= kind === 'error';
        super.addEventListener(kind, ...rest);
    }

    /** As many pixels as it has on the screen. */
    #followSize() {
        const element = this.#element;
        const take = (width, height) => {
            if (this.#isOver || width < 1 || height < 1) return;
            const [before, high] = [element.clientWidth, element.clientHeight];
            this.#canvas.resize(width, height);
            if (element.clientWidth !== before || element.clientHeight !== high) {
                // Nobody said how large it is on the page: its pixels would, and grow by what they say.
                element.style.width = `${before}px`;
                element.style.height = `${high}px`;
            }
            this.#wake();
        };
        this.#follower = new ResizeObserver(([entry]) => {
            const pixels = entry.devicePixelContentBoxSize?.[0];
            const ratio = globalThis.devicePixelRatio ?? 1;
            if (pixels) take(pixels.inlineSize, pixels.blockSize);
            else take(Math.round(element.clientWidth * ratio), Math.round(element.clientHeight * ratio));
        });
        try {
            this.#follower.observe(element, { box: 'device-pixel-content-box' });
        } catch {
            // Safari has no such box.
            this.#follower.observe(element);
        }
    }

    #listen() {
        const element = this.#element;
        const { signal } = this.#controls;
        const pointers = new Map();
        const on = (kind, hear, options = {}) => element.addEventListener(kind, hear, { signal, ...options });
        element.style.touchAction = 'none';
        on('contextmenu', (event) => event.preventDefault());
        on('pointerdown', (event) => {
            element.setPointerCapture(event.pointerId);
            pointers.set(event.pointerId, event);
        });
        const release = (event) => pointers.delete(event.pointerId);
        on('pointerup', release);
        on('pointercancel', release);
        on('pointermove', (event) => {
            const before = pointers.get(event.pointerId);
            if (!before) return;
            const height = element.clientHeight || 1;
            const others = [...pointers.values()].filter(({ pointerId }) => pointerId !== event.pointerId);
            let has;
            if (others.length > 0) {
                has = this.#canvas.fingers(...fingers(before, event, others[0], height));
            } else {
                const button = event.pointerType === 'touch' ? 0 : pressed(event.buttons);
                const command = event.ctrlKey || event.metaKey;
                has = this.#canvas.drag(button, event.shiftKey, command, (event.clientX - before.clientX) / height, (event.clientY - before.clientY) / height);
            }
            pointers.set(event.pointerId, event);
            if (has) this.#moved();
        });
        on('wheel', (event) => {
            event.preventDefault();
            const notches = -event.deltaY / (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 3 : 100);
            this.zoom(notches);
        }, { passive: false });
        on('dblclick', () => this.look());
    }
}

/** The button of a mouse that is held, by its bit. */
function pressed(buttons) {
    if (buttons & 1) return 0;
    if (buttons & 2) return 2;
    return buttons & 4 ? 1 : -1;
}

/** What two fingers do, of which one moved. */
function fingers(before, now, other, height) {
    const to = (event) => [event.clientX - other.clientX, event.clientY - other.clientY];
    const [from, at] = [to(before), to(now)];
    const turned = Math.atan2(at[1], at[0]) - Math.atan2(from[1], from[0]);
    const around = Math.atan2(Math.sin(turned), Math.cos(turned));
    // The point between them moves by half.
    const [right, down] = [now.clientX - before.clientX, now.clientY - before.clientY].map((by) => by / 2 / height);
    return [right, down, Math.hypot(...at) / Math.max(Math.hypot(...from), 1), around];
}

function written(scene) {
    return typeof scene === 'string' ? scene : JSON.stringify({ lumivox_scene: 1, ...scene });
}

/** Calls at the browser's next frame, or soon where it has none: in some Workers, and in a page that nobody sees. Gives what calls it off. */
function soon(call) {
    let frame;
    const off = () => {
        clearTimeout(timer);
        if (frame !== undefined) cancelAnimationFrame(frame);
    };
    const once = () => {
        off();
        call();
    };
    const hasFrames = typeof requestAnimationFrame === 'function';
    const timer = setTimeout(once, hasFrames ? 500 : 16);
    if (hasFrames) frame = requestAnimationFrame(once);
    return off;
}
