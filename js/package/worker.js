// The same program beside the page, in a memory of its own: reads one scan.
import start, { read } from './lumivox_wasm.js';

onmessage = async ({ data: { module, pairs, wanted } }) => {
    try {
        await start({ module_or_path: module });
        const told = read(pairs, wanted, (stage, done, total) => postMessage({ stage, done, total }));
        postMessage(told, [told.voxels.buffer]);
    } catch (error) {
        postMessage({ failed: String(error?.message ?? error) });
    }
};
