/** A typed array of numbers. Integers of 32 bits and doubles become floats of 32 bits, which GPUs compute with. */
export type Numbers =
    | Uint8Array | Uint8ClampedArray | Int8Array | Uint16Array | Int16Array | Uint32Array | Int32Array | Float32Array | Float64Array;

/** What is said of voxels. A value is `stored * slope + intercept`. */
export interface Description {
    /** Voxels along x (fastest), y and z. */
    dims: [number, number, number];
    /** Distances between voxels in mm, where x grows to the patient's left, y to the back and z to the head; 1 mm where nothing is said. */
    spacing?: [number, number, number];
    /** In place of `spacing`, all of it: voxel indices (centres at whole numbers) to the patient's millimetres (LPS), three rows of four. */
    patientFromVoxel?: [number, number, number, number][];
    slope?: number;
    intercept?: number;
    /** What made it; of a CT, values are Hounsfield units. */
    modality?: 'CT' | 'MR' | 'PET' | 'other';
    unit?: string;
}

/** A label of voxels. */
export interface Label {
    /** Of its voxels, 1 to 255; 0 is no label. */
    value: number;
    name: string;
    /** Linear RGB, 0 to 1. */
    color?: [number, number, number];
}

/** Voxels with their place in the patient. */
export class Scan {
    /** Voxels are copied. `await load()` comes first. */
    constructor(voxels: Numbers, description: Description);
    /** A head that nobody has, of so many voxels along each axis. */
    static phantom(size?: number): Promise<Scan>;
    /** Voxels along x, y and z. */
    readonly dims: [number, number, number];
    /** The lowest and the highest value. */
    readonly valueRange: [number, number];
    /** What values are measured in, such as `HU`; empty where that is not known. */
    readonly unit: string;
    /** The look that suits it. */
    readonly preset: string;
    /** What could be read of the files, the best first. */
    series: string[];
    /** What is worth knowing of how it was read. */
    notes: string[];
    /** Says of each voxel which label it has. A scene's `labels.styles` say how each looks. */
    setLabels(voxels: Uint8Array, labels: Label[]): this;
    /** Says how deep points lie below the skin, by a scan of any grid whose values are millimetres. A scene's `peel` takes off so many. */
    setDepth(depth: Scan): this;
    /** Gives its memory back. Views that show it keep what they need. */
    free(): void;
}

export interface ReadOptions {
    /** A place in the list of series from 1, a SeriesInstanceUID or a series number; the best where nothing is said. */
    series?: string;
    /** Which phase of a series with several, from 1. */
    phase?: number;
    /** Of a CT the patient alone, where that can be told for sure, or everything. */
    keep?: 'patient' | 'everything';
    /** The look it is to have, which decides whether skin is taken off. */
    preset?: string;
    /** Hears how far it is, some twenty times a second. */
    onprogress?: (progress: { stage: string; done: number; total: number }) => void;
    /** Ends it. */
    signal?: AbortSignal;
}

/**
 * Reads files (DICOM, NIfTI, NRRD, MetaImage, zip archives) in a Worker. Nothing leaves this machine.
 * @param files Files of a dialog or a drop; or pairs of a path and a file, where folders matter.
 */
export function readScan(files: Iterable<File | [string, File]>, options?: ReadOptions): Promise<Scan>;

/** How far a picture is. */
export interface Progress {
    /** Samples that every pixel has. */
    samples: number;
    /** The part of all samples, 0 to 1. */
    part: number;
    /** Whether something of the scene is seen. */
    isShown: boolean;
    /** Whether it is done until something changes. */
    rests: boolean;
}

/** What is seen at a point. */
export interface Picked {
    /** Which scan, from 0. */
    volume: number;
    /** Its value there. */
    value: number;
    voxel: [number, number, number];
    /** The patient's millimetres (LPS). */
    patient: [number, number, number];
}

/** A scene document, as every host of Lumivox saves and opens it: docs/scenes.md. */
export type Scene = Record<string, any>;

export interface ViewOptions {
    /** Samples of a pixel at which the picture is done; 512 where nothing is said. */
    samples?: number;
    /** Whether mouse, wheel and fingers move the camera. */
    controls?: boolean;
    /** Which mouse people are used to. */
    mouse?: 'ohif' | 'slicer';
    /** Whether it has as many pixels as it covers on the screen. */
    resize?: boolean;
}

/** A view of scans on a canvas. */
export class View extends EventTarget {
    /** On a page's canvas, or on an `OffscreenCanvas`, which has no controls. Throws where there is no WebGPU. */
    static create(canvas: HTMLCanvasElement | OffscreenCanvas, options?: ViewOptions): Promise<View>;
    /** Shows scans as they are given. A scene's volumes are these, one after the other; without one, each looks as suits it. */
    show(scans: Scan | Scan[], scene?: Scene | string): void;
    /** What is shown, with the camera as it stands; set, the same scans look as it says. */
    get scene(): Scene | null;
    set scene(scene: Scene | string);
    /** The first scan's look, by its name. */
    get preset(): string | null;
    set preset(preset: string);
    set samples(samples: number);
    set mouse(name: 'ohif' | 'slicer');
    /** The GPU's name, as far as the browser tells it. */
    readonly gpu: string;
    /** The camera around all there is to see: degrees around the vertical and above the horizon; how many times closer than where all fits. */
    look(from?: { azimuth?: number; elevation?: number; zoom?: number }): void;
    /** Turns it as dragging does: to the right and down, in heights of the view. */
    turn(right: number, down: number): void;
    /** Comes closer by so many notches of a wheel. */
    zoom(notches: number): void;
    /** What is seen at a point, in parts of the view's width and height; `null` where hardly anything is. */
    pick(x: number, y: number): Picked | null;
    /** Resolves when the picture is done. */
    rest(): Promise<Progress>;
    /** What is seen now, as a file. */
    picture(type?: string, quality?: number): Promise<Blob>;
    /** Gives it so many pixels, where `resize` is off. */
    resize(width: number, height: number): void;
    /** Shows nothing any more, and frees the GPU's memory. */
    clear(): void;
    /** Ends it. */
    destroy(): void;
    addEventListener(kind: 'progress', hear: (event: CustomEvent<Progress>) => void, options?: boolean | AddEventListenerOptions): void;
    addEventListener(kind: 'camera', hear: (event: Event) => void, options?: boolean | AddEventListenerOptions): void;
    addEventListener(kind: 'error', hear: (event: Event & { error: Error }) => void, options?: boolean | AddEventListenerOptions): void;
}

/** The looks there are. */
export function presets(): Promise<{ name: string; description: string }[]>;

/** Why there can be no picture here, in words; empty where there can. */
export function obstacle(): Promise<string>;

/** Loads the program once, from beside this file unless it is said from where. Views and readers do so by themselves. */
export function load(from?: URL | string | ArrayBuffer | Uint8Array | WebAssembly.Module): Promise<void>;
