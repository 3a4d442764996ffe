// What this browser's compiler says of kernels: `cargo xtask web kernels` calls these, one after the other.

/** What a pipeline's layout says of a binding, by its kind. */
const LAYOUTS = {
    uniform: { buffer: { type: 'uniform' } },
    read: { buffer: { type: 'read-only-storage' } },
    write: { buffer: { type: 'storage' } },
    texture3d: { texture: { sampleType: 'float', viewDimension: '3d' } },
    texture2d: { texture: { sampleType: 'unfilterable-float', viewDimension: '2d' } },
    sampler: { sampler: { type: 'filtering' } },
};

let device;
/** Of the kernels that were given last: a list of refusals for each that was looked at, and why there is no device any more. */
let outcome = { each: [], gone: null };

/** Asks for a device with WebGPU's own limits; says who makes it, and what compiles for it. */
export async function begin() {
    const adapter = await adapterOf(navigator.gpu);
    if (!adapter) throw new Error('the browser finds no graphics card');
    device = await adapter.requestDevice();
    device.lost.then(({ message }) => { outcome.gone = `the device is lost: ${message}`; });
    const { uaFullVersion } = await navigator.userAgentData.getHighEntropyValues(['uaFullVersion']);
    const { vendor, architecture } = adapter.info;
    return { browser: `Chromium ${uaFullVersion}`, device: `${vendor} ${architecture}` };
}

/** A browser that has just begun finds no graphics card for a moment. */
async function adapterOf(gpu) {
    for (let tries = 10; ; tries--) {
        const adapter = await gpu.requestAdapter();
        if (adapter || tries === 0) return adapter;
        await new Promise((done) => setTimeout(done, 400));
    }
}

/** What came out so far, for who does not wait any longer. */
export const told = () => outcome;

/** Gives texts to the compiler. */
export const modules = (kernels) => all(kernels, async ({ text }) => {
    const { messages } = await device.createShaderModule({ code: text }).getCompilationInfo();
    const lines = text.split('\n');
    const refusals = messages.filter(({ type }) => type === 'error');
    return refusals.map(({ message, lineNum }) => ({ what: `${message}: ${lines[lineNum - 1]?.trim()}`, line: lineNum }));
});

/** Has the driver compile them, too, as it would for a picture. */
export const pipelines = (kernels) => all(kernels, async ({ text, entry, kind, bindings }) => {
    const module = device.createShaderModule({ code: text });
    const visibility = kind === 'compute' ? GPUShaderStage.COMPUTE : GPUShaderStage.FRAGMENT;
    const entries = bindings.map((name, binding) => ({ binding, visibility, ...LAYOUTS[name] }));
    const layout = device.createPipelineLayout({ bindGroupLayouts: [device.createBindGroupLayout({ entries })] });
    const program = { module, entryPoint: entry };
    if (kind === 'compute') {
        await device.createComputePipelineAsync({ layout, compute: program });
        return [];
    }
    const isColor = kind !== 'depth';
    const [source, target] = ['one', 'one-minus-src-alpha'];
    const component = { srcFactor: source, dstFactor: target, operation: 'add' };
    const blend = kind === 'color' ? { color: component, alpha: component } : undefined;
    const targets = isColor ? [{ format: 'rgba16float', blend }] : [];
    const depthStencil = isColor ? undefined : { format: 'depth32float', depthWriteEnabled: true, depthCompare: 'always' };
    const vertex = { module, entryPoint: 'fullscreen' };
    await device.createRenderPipelineAsync({ layout, vertex, fragment: { ...program, targets }, depthStencil });
    return [];
});

/** Does so with one after the other, until there are no more, or one has cost the device: that is the first of which nothing is told. */
async function all(kernels, compile) {
    outcome.each = [];
    for (const kernel of kernels) {
        device.pushErrorScope('validation');
        const refusals = await compile(kernel).catch((error) => [{ what: error.message, line: null }]);
        const error = await device.popErrorScope().catch(() => null);
        if (error && refusals.length === 0) refusals.push({ what: error.message, line: null });
        await isThere();
        if (outcome.gone !== null) break;
        outcome.each.push(refusals);
    }
    return outcome;
}

/** Waits for an answer of the device, or the news that it is lost, which may come later than all else fails. */
async function isThere() {
    const buffer = device.createBuffer({ size: 4, usage: GPUBufferUsage.MAP_READ });
    await buffer.mapAsync(GPUMapMode.READ).catch(() => device.lost);
    buffer.destroy();
}
