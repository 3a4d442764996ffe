// What a program would do with the package, in a real browser: `script/js --test` calls these one after the other.
import { Scan, View, load, obstacle, presets, readScan } from './lumivox.js';

function check(is, what) {
    if (!is) throw new Error(what);
}

/** Throws where `work` does not fail with these words. */
async function fails(words, work) {
    let why;
    try {
        await work();
    } catch (error) {
        why = error.message;
    }
    check(why !== undefined, `it should fail: ${words}`);
    check(why.includes(words), `it should say '${words}', and says '${why}'`);
}

/** Pixels of what is seen. */
async function pixels(view) {
    return pixelsOf(await view.picture());
}

async function pixelsOf(picture) {
    const image = await createImageBitmap(picture);
    const paper = new OffscreenCanvas(image.width, image.height).getContext('2d');
    paper.drawImage(image, 0, 0);
    return { width: image.width, height: image.height, data: paper.getImageData(0, 0, image.width, image.height).data };
}

function at({ width, data }, x, y) {
    const place = 4 * (y * width + x);
    return [...data.slice(place, place + 3)];
}

const brightness = ([red, green, blue]) => (red + green + blue) / 3;

/** Mean difference of two pictures, of 255. */
function difference(one, other) {
    check(one.width === other.width && one.height === other.height, 'pictures of different sizes');
    let sum = 0;
    for (let place = 0; place < one.data.length; place++) sum += Math.abs(one.data[place] - other.data[place]);
    return sum / one.data.length;
}

const SIDE = 64;

async function small(options = {}) {
    return View.create(new OffscreenCanvas(SIDE, SIDE), { samples: 4, ...options });
}

/** A ball of 1000 HU in air, of 32 voxels a side of 2 mm. */
function ball(Numbers, offset = 0) {
    const voxels = new Numbers(32 ** 3).fill(-1000 + offset);
    for (let z = 0; z < 32; z++)
        for (let y = 0; y < 32; y++)
            for (let x = 0; x < 32; x++)
                if (Math.hypot(x - 15.5, y - 15.5, z - 15.5) < 11) voxels[(z * 32 + y) * 32 + x] = 1000 + offset;
    return voxels;
}

const BALL = { dims: [32, 32, 32], spacing: [2, 2, 2], modality: 'CT' };
const BONE = { volumes: [{ scan: {}, look: { preset: 'ct-bone' } }] };

/** What is wrong is said before anything is loaded, and after. */
export async function wrongs() {
    check(await obstacle() === '', `there is WebGPU here: ${await obstacle()}`);
    await fails('await load() comes first', () => new Scan(new Uint8Array(1), { dims: [1, 1, 1] }));
    await fails('404', () => load('nowhere.wasm'));
    await load();
    await fails('typed array', () => new Scan([1, 2], { dims: [1, 1, 2] }));
    await fails('8 voxels, but 7 samples', () => new Scan(new Uint8Array(7), { dims: [2, 2, 2] }));
    await fails('each above 0', () => new Scan(new Uint8Array(1), { dims: [1, 1, 1], spacing: [1, 0, 1] }));
    await fails('unknown field `size`', () => new Scan(new Uint8Array(1), { size: [1, 1, 1] }));
    await fails('needs a canvas', () => View.create(document.body));
    await fails("'ohif' or 'slicer'", () => small({ mouse: 'mickey' }));
    await fails('there is no file', () => readScan([]));
    const view = await small();
    await fails('nothing is shown yet', () => { view.preset = 'ct-bone'; });
    check(view.scene === null && view.preset === null && view.pick(0.5, 0.5) === null, 'an empty view shows nothing');
    const scan = new Scan(ball(Int16Array), BALL);
    await fails('ct-brick', () => view.show(scan, { volumes: [{ scan: {}, look: { preset: 'ct-brick' } }] }));
    await fails('2 volumes, and 1 scans', () => view.show(scan, { volumes: [...BONE.volumes, ...BONE.volumes] }));
    await fails('is a file, which is not looked for', () => view.show(scan, { environment: { source: 'sky.hdr' } }));
    view.destroy();
    view.destroy();
    check((await presets()).some(({ name, description }) => name === 'ct-bone' && description !== ''), 'ct-bone is a look');
    return 'what is wrong is said';
}

/** Arrays of every kind show the same, and what is seen is where it is said to be. */
export async function arrays() {
    const view = await small();
    const shown = async (voxels, description) => {
        const scan = new Scan(voxels, { ...BALL, ...description });
        view.show(scan, BONE);
        scan.free();
        const { samples, isShown } = await view.rest();
        check(samples === 4 && isShown, `the picture is done after ${samples} samples`);
        return pixels(view);
    };
    const first = await shown(ball(Int16Array));
    const middle = brightness(at(first, SIDE / 2, SIDE / 2)), edge = brightness(at(first, 2, 2));
    check(middle > 80 && edge < 30, `the ball is seen: ${middle} in its middle, ${edge} beside it`);
    const others = {
        unsigned: await shown(ball(Uint16Array, 1024), { intercept: -1024 }),
        floats: await shown(ball(Float32Array)),
        doubles: await shown(ball(Float64Array)),
        'long integers': await shown(ball(Int32Array)),
        bytes: await shown(Uint8Array.from(ball(Float32Array), (value) => (value + 1000) / 20), { slope: 20, intercept: -1000 }),
        'signed bytes': await shown(Int8Array.from(ball(Float32Array), (value) => value / 20), { slope: 20 }),
    };
    for (const [kind, other] of Object.entries(others)) {
        const by = difference(first, other);
        check(by < 2, `${kind} differ by ${by}`);
    }
    // Seen from the front, whose side faces -y: 11 voxels of 2 mm before the middle.
    const picked = view.pick(0.5, 0.5);
    check(picked?.volume === 0 && picked.value > 0, `the ball is picked: ${JSON.stringify(picked)}`);
    const [x, y, z] = picked.patient;
    check(Math.abs(x - 31) < 2 && Math.abs(y - 9) < 3 && Math.abs(z - 31) < 2, `it is where it should be: ${picked.patient}`);
    check(view.pick(0.02, 0.02) === null, 'beside it nothing is picked');
    view.destroy();
    return `a ball of seven kinds of numbers: ${middle.toFixed(0)} in its middle, ${edge.toFixed(0)} beside it`;
}

/** A scene that one view saves is the same in another; looks, labels and cameras change what is seen. */
export async function scenes() {
    const view = await small(), other = await small();
    const scan = await Scan.phantom(32);
    check(scan.dims.join() === '32,32,32' && scan.unit === 'HU' && scan.preset.startsWith('ct-'), 'a phantom is a CT');
    view.show(scan);
    await view.rest();
    const usual = await pixels(view);
    check(view.preset === scan.preset, 'it looks as suits it');
    view.preset = 'ct-bone';
    check(view.preset === 'ct-bone', 'the look is another');
    view.look({ azimuth: 35, elevation: 10, zoom: 1.2 });
    view.turn(0.1, 0.05);
    await view.rest();
    const turned = await pixels(view);
    check(difference(usual, turned) > 3, `another look, from elsewhere: ${difference(usual, turned)}`);
    const saved = JSON.stringify(view.scene);
    other.show([scan], saved);
    await other.rest();
    const by = difference(turned, await pixels(other));
    check(by < 1, `the same scene in another view differs by ${by}`);
    check(JSON.stringify(other.scene.camera) === JSON.stringify(view.scene.camera), 'from the same place');
    // As the guide changes a scene: half of it, brighter, on a colour.
    const cut = view.scene;
    cut.display = { exposure: 0.5, background: '#104418' };
    cut.volumes[0].clip = [[0, 0, 0], [0.5, 1, 1]];
    view.scene = cut;
    await view.rest();
    const seen = await pixels(view);
    check(at(seen, 2, 2).every((code, place) => Math.abs(code - [0x10, 0x44, 0x18][place]) < 4), `its background is ${at(seen, 2, 2)}`);
    check(difference(turned, seen) > 3, `half of it is seen: ${difference(turned, seen)}`);
    const halves = new Uint8Array(32 ** 3).map((_, place) => place % 32 < 16 ? 1 : 2);
    scan.setLabels(halves, [{ value: 1, name: 'right' }, { value: 2, name: 'left', color: [1, 0, 0] }]);
    const scene = JSON.parse(saved);
    scene.volumes[0].labels = { files: [], styles: [{ label: 'left', visible: false }] };
    other.show(scan, scene);
    await other.rest();
    const half = difference(turned, await pixels(other));
    check(half > 3, `a label is hidden: ${half}`);
    await fails('no such label', () => {
        scene.volumes[0].labels.styles[0].label = 'middle';
        other.scene = scene;
    });
    scan.free();
    other.clear();
    check(other.scene === null, 'it is cleared');
    view.destroy();
    other.destroy();
    return `a scene is the same in two views, to ${by.toFixed(2)} of 255`;
}

/** Files are read by a Worker, which tells how far it is and can be ended. */
export async function files(names) {
    const given = await Promise.all(names.map(async (name) => {
        const answer = await fetch(`scan/${name}`);
        return new File([await answer.blob()], name);
    }));
    const stages = new Set();
    const scan = await readScan(given, { onprogress: ({ stage, total }) => { if (total > 0) stages.add(stage); } });
    check(scan.dims.join() === '32,32,32' && scan.unit === 'HU', `a scan of ${scan.dims} ${scan.unit}`);
    check(scan.series.length === 1 && scan.series[0].includes('CT'), `one series: ${scan.series}`);
    check(stages.size > 0, 'it tells how far it is');
    const view = await small();
    view.show(scan, BONE);
    await view.rest();
    const middle = brightness(at(await pixels(view), SIDE / 2, SIDE / 2));
    check(middle > 40, `the scan is seen: ${middle}`);
    view.destroy();
    const pairs = given.map((file) => [`study/${file.name}`, file]);
    check((await readScan(pairs, { keep: 'everything' })).dims.join() === '32,32,32', 'paths are heeded');
    await fails('words.txt', () => readScan([new File(['no scan'], 'words.txt')]));
    await fails('series', () => readScan(given, { series: '7' }));
    await fails('enough', () => readScan(given, { signal: AbortSignal.abort(new Error('enough')) }));
    return `${names.length} files are read: ${[...stages].join(', ')}`;
}

/** A view in a Worker of a program's own. */
export async function elsewhere() {
    const worker = new Worker(new URL('elsewhere.js', import.meta.url), { type: 'module' });
    const canvas = new OffscreenCanvas(SIDE, SIDE);
    const told = await new Promise((done, failed) => {
        worker.onmessage = ({ data }) => done(data);
        worker.onerror = (event) => failed(new Error(event.message));
        worker.postMessage(canvas, [canvas]);
    });
    worker.terminate();
    check(told.failed === undefined, `a Worker shows it: ${told.failed}`);
    check(told.samples === 4 && told.isShown, `a Worker's picture is done after ${told.samples} samples`);
    const seen = await pixelsOf(told.picture);
    const middle = brightness(at(seen, SIDE / 2, SIDE / 2));
    check(middle > 40 && brightness(at(seen, 2, 2)) < 40, `a Worker's picture shows it: ${middle}`);
    return `a Worker shows it on an OffscreenCanvas: ${middle.toFixed(0)} in its middle`;
}

/** The page's own view, which a mouse turns. */
export async function controls() {
    const canvas = document.getElementById('view');
    const view = await View.create(canvas.cloneNode(), { samples: 4, resize: false, controls: true });
    view.destroy();
    window.moved = 0;
    const replaced = canvas.cloneNode();
    // A processor draws it.
    replaced.style.cssText = 'flex: none; width: 240px; height: 160px';
    canvas.replaceWith(replaced);
    window.view = await View.create(replaced, { samples: 2 });
    window.view.addEventListener('camera', () => { window.moved += 1; });
    window.view.show(await Scan.phantom(32));
    await window.view.rest();
    const { width, height, clientWidth, clientHeight } = replaced;
    check(width === Math.round(clientWidth * devicePixelRatio) && height === Math.round(clientHeight * devicePixelRatio),
        `as many pixels as it covers: ${width} x ${height} for ${clientWidth} x ${clientHeight}`);
    return `a view of ${width} x ${height} pixels`;
}
