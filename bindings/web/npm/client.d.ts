import type { Deformed, DeformedFile, Mesh, Options } from './index.js';
export { KneadError } from './index.js';

export interface WorkerOptions extends Options {
  /** Cancels the call: its promise is rejected with the signal's reason, and the next call starts another worker. */
  signal?: AbortSignal;
}

/** The functions of the module in a worker. Calls wait for each other. */
export interface KneadWorker {
  deform<T extends Float32Array | Float64Array>(mesh: Mesh<T>, session: string, options?: WorkerOptions): Promise<Deformed<T>>;
  deformFile(file: Uint8Array | ArrayBuffer, name: string, session: string, options?: WorkerOptions): Promise<DeformedFile>;
  readShape(
    file: Uint8Array | ArrayBuffer,
    name: string,
    options?: Pick<WorkerOptions, 'signal'>,
  ): Promise<{ positions: Float64Array; indices: Uint32Array; faceBegin: Uint32Array }>;
  /** Ends the worker. */
  close(): void;
}

/** Starts a worker of a browser at the first call. */
export function startWorker(): KneadWorker;
