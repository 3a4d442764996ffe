// The same program beside the page, in a memory of its own, for one errand.
import start, { work } from './lumivox_studio.js';

onmessage = async ({ data: { module, letter, bytes, files } }) => {
    try {
        await start({ module_or_path: module });
        work(letter, bytes, files, (letter, bytes) => postMessage([letter, bytes], bytes.map((part) => part.buffer)));
        postMessage(['', []]);
    } catch (error) {
        console.error(error);
        postMessage([null, []]);
    }
};

onmessageerror = () => postMessage([null, []]);
