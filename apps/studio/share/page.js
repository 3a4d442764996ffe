const find = (id) => document.getElementById(id);
const { scans, document: scene, looks, structures, words } = JSON.parse(find('scene').textContent);
const blocks = [...document.querySelectorAll('script[type="application/gzip"]')];

/** The next of the parts that are no text; the page forgets it. */
async function next() {
    const block = blocks.shift();
    const packed = Uint8Array.from(atob(block.textContent), (letter) => letter.charCodeAt(0));
    block.remove();
    const bytes = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
    return new Response(bytes).arrayBuffer();
}

const text = async () => new TextDecoder().decode(await next());
const script = (words) => URL.createObjectURL(new Blob([words], { type: 'text/javascript' }));
const ARRAYS = { uint8: Uint8Array, uint16: Uint16Array };

async function scanOf(lumivox, { kind, description, labels, depth }) {
    const numbers = async (kind) => new ARRAYS[kind](await next());
    const scan = new lumivox.Scan(await numbers(kind), description);
    if (labels) scan.setLabels(await numbers('uint8'), labels);
    if (depth) scan.setDepth(new lumivox.Scan(await numbers(depth.kind), depth.description));
    return scan;
}

async function run() {
    const [calls, binding] = [await text(), await text()];
    const lumivox = await import(script(calls.replace('./lumivox_wasm.js', script(binding))));
    const why = await lumivox.obstacle();
    if (why) throw new Error(why);
    await lumivox.load(await next());
    const all = [];
    for (const told of scans) all.push(await scanOf(lumivox, told));
    const view = await lumivox.View.create(find('view'));
    view.addEventListener('progress', ({ detail }) => {
        find('samples').textContent = `${detail.samples} ${words.samples}`;
        if (detail.isShown) find('told').hidden = true;
    });
    view.addEventListener('error', ({ error }) => say(error));
    view.show(all, scene);
    offer(view);
    // For programs.
    window.view = view;
}

/** What can be changed about it. */
function offer(view) {
    const change = (how) => {
        const scene = view.scene;
        how(scene);
        view.scene = scene;
    };
    const look = find('look');
    look.add(new Option(words.asShared, ''));
    for (const { preset, name } of looks) look.add(new Option(name, preset));
    look.onchange = () => change(({ volumes: [first] }) => {
        first.look = look.value === '' ? scene.volumes[0].look : { preset: look.value };
    });
    look.parentElement.hidden = looks.length === 0;
    find('structures').hidden = structures.length === 0;
    for (const { label, name, isVisible } of structures) {
        const box = Object.assign(document.createElement('input'), { type: 'checkbox', checked: isVisible });
        box.onchange = () => change(({ volumes: [{ labels }] }) => {
            const others = (labels.styles ?? []).filter((style) => style.label !== label);
            const own = (labels.styles ?? []).findLast((style) => style.label === label);
            labels.styles = [...others, { ...own, label, visible: box.checked }];
        });
        const row = document.createElement('label');
        row.append(box, ` ${name}`);
        find('structures').append(row);
    }
    find('reset').onclick = () => change((now) => { now.camera = scene.camera; });
    find('view').onkeydown = ({ key }) => {
        const turns = { ArrowLeft: [-0.05, 0], ArrowRight: [0.05, 0], ArrowUp: [0, -0.05], ArrowDown: [0, 0.05] }[key];
        const notches = { '+': 1, '-': -1 }[key];
        if (turns) view.turn(...turns);
        if (notches) view.zoom(notches);
    };
    document.querySelector('aside').hidden = false;
    find('view').focus();
}

function say(error) {
    find('told').textContent = error?.message ?? String(error);
    find('told').hidden = false;
}

run().catch((error) => {
    console.error(error);
    say(error);
});
