// A scan on a page: the head that comes along, or files that somebody chooses. Nothing leaves this machine.
import { Scan, View, presets, readScan } from './lumivox.js';

const told = document.getElementById('told');
const looks = document.getElementById('look');

async function run() {
    const view = await View.create(document.getElementById('view'));
    view.addEventListener('progress', ({ detail }) => { told.textContent = `${detail.samples} samples`; });
    view.addEventListener('error', ({ error }) => { told.textContent = error.message; });
    for (const { name, description } of await presets()) looks.add(Object.assign(new Option(name, name), { title: description }));
    looks.onchange = () => { view.preset = looks.value; };

    const show = (scan) => {
        view.show(scan);
        looks.value = view.preset;
        // The view keeps what it needs.
        scan.free();
    };
    document.getElementById('files').onchange = async ({ target }) => {
        if (target.files.length === 0) return;
        try {
            const onprogress = ({ stage, done, total }) => { told.textContent = `${stage} ${Math.round(100 * done / Math.max(total, 1))}%`; };
            show(await readScan(target.files, { onprogress }));
        } catch (error) {
            told.textContent = error.message;
        }
    };
    show(await Scan.phantom(128));
}

run().catch((error) => {
    console.error(error);
    told.textContent = error.message;
});
