// The functions of index.js in a worker: the page goes on meanwhile, sees how far a call is, and can cancel it.
import { KneadError } from './error.js';

export { KneadError };

// One worker. Calls wait for each other. A cancelled call ends the worker; the next call starts another.
class Client {
  constructor() {
    this.id = 0;
    this.last = Promise.resolve();
  }

  start() {
    this.worker ??= new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
    return this.worker;
  }

  close(reason = new KneadError('the worker was closed')) {
    this.worker?.terminate();
    this.worker = null;
    this.fail?.(reason);
  }

  call(name, args, { signal, onProgress, ...options }) {
    const begin = () => this.perform(name, [...args, options], signal, onProgress);
    const result = this.last.then(begin, begin);
    this.last = result.catch(() => {});
    return result;
  }

  perform(name, args, signal, onProgress) {
    signal?.throwIfAborted();
    const worker = this.start();
    this.id += 1;
    const { id } = this;
    return new Promise((resolve, reject) => {
      const cancel = () => this.close(signal.reason);
      const finish = (settle, value) => {
        signal?.removeEventListener('abort', cancel);
        this.fail = null;
        settle(value);
      };
      this.fail = (reason) => finish(reject, reason);
      signal?.addEventListener('abort', cancel);
      worker.onerror = (event) => this.close(new Error(event.message ?? 'the worker cannot be started'));
      worker.onmessage = ({ data }) => {
        if (data.id !== id) return;
        if (data.fraction !== undefined) return onProgress?.(data.fraction);
        if (data.error !== undefined) return finish(reject, data.isKnead ? new KneadError(data.error) : new Error(data.error));
        finish(resolve, data.result);
      };
      worker.postMessage({ id, name, args, hasProgress: onProgress !== undefined });
    });
  }
}

// Returns the library's functions in a worker of their own.
export function startWorker() {
  const client = new Client();
  return {
    deform: (mesh, session, options = {}) => client.call('deform', [mesh, session], options),
    deformFile: (file, name, session, options = {}) => client.call('deformFile', [file, name, session], options),
    readShape: (file, name, options = {}) => client.call('readShape', [file, name], options),
    close: () => client.close(),
  };
}
