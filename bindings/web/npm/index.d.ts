/** A mesh, or a point cloud if it has no indices. */
export interface Mesh<T extends Float32Array | Float64Array = Float32Array | Float64Array> {
  /** x y z of each vertex. */
  positions: T;
  /** The vertex of each corner of the faces, counter-clockwise seen from outside. */
  indices?: ArrayLike<number>;
  /** Where each face begins in `indices`, and the length of `indices`; without it all faces are triangles. */
  faceBegin?: ArrayLike<number>;
}

/** The options of `knead deform` that hold here, with its defaults. */
export interface Options {
  /** Position error of one path line over one segment, relative to the diagonal of the shape's box: 1e-5. */
  tolerance?: number;
  /** Of the fields' evaluation: 'float'. */
  precision?: 'float' | 'double';
  integrator?: 'tsit5' | 'rk4';
  /** Applies the session backwards. */
  inverse?: boolean;
  /** Only so many strokes; 2.5: two and half of the third. */
  until?: number;
  /** The files that the session names (shapes of stamps), by their names there. */
  files?: Record<string, Uint8Array | ArrayBuffer>;
  /** Called after each stroke, with how much of the work is done: 0 to 1. */
  onProgress?: (fraction: number) => void;
  /** Adds the report of `knead deform --report` to the result. */
  report?: boolean;
}

export interface Deformed<T> {
  positions: T;
  /** If the session remeshes: the new faces, with any number of corners. */
  indices?: Uint32Array;
  faceBegin?: Uint32Array;
  report?: Record<string, unknown>;
}

export interface DeformedFile {
  file: Uint8Array;
  report?: Record<string, unknown>;
}

/** One line that says what is wrong and what to do. All functions throw it, by a promise that is rejected. */
export class KneadError extends Error {}

/** Loads the library once. The other functions do it themselves at their first call. */
export function load(): Promise<unknown>;

/**
 * Deforms a mesh, which stays as it is, by a session: the text of a `.knead` file. The result has the bits of
 * `knead deform`, rounded to the type of `positions`. Runs until it is done: call it from a worker where that takes long.
 */
export function deform<T extends Float32Array | Float64Array>(
  mesh: Mesh<T>,
  session: string,
  options?: Options,
): Promise<Deformed<T>>;

/** Deforms the bytes of a file; `name` has its extension. Returns what `knead deform --digits shortest` writes. */
export function deformFile(
  file: Uint8Array | ArrayBuffer,
  name: string,
  session: string,
  options?: Options,
): Promise<DeformedFile>;

/** Reads a PLY, OBJ, STL, OFF, GLB or point file; `name` has its extension. */
export function readShape(
  file: Uint8Array | ArrayBuffer,
  name: string,
): Promise<{ positions: Float64Array; indices: Uint32Array; faceBegin: Uint32Array }>;
