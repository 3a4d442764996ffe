// A view in a Worker of a program's own, which has the program's bytes.
import { Scan, View, load } from './lumivox.js';

onmessage = async ({ data: canvas }) => {
    try {
        const bytes = await (await fetch('lumivox_wasm_bg.wasm')).arrayBuffer();
        await load(new DataView(bytes));
        const view = await View.create(canvas, { samples: 4 });
        const scan = await Scan.phantom(32);
        view.show(scan, { volumes: [{ scan: {}, look: { preset: 'ct-bone' } }] });
        const { samples, isShown } = await view.rest();
        postMessage({ samples, isShown, picture: await view.picture() });
        view.destroy();
    } catch (error) {
        postMessage({ failed: error.message });
    }
};
