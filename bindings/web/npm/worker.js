// The library in a worker: client.js sends calls.
import * as knead from './index.js';

self.onmessage = async ({ data: { id, name, args, hasProgress } }) => {
  const options = args.at(-1);
  if (hasProgress) options.onProgress = (fraction) => self.postMessage({ id, fraction });
  try {
    self.postMessage({ id, result: await knead[name](...args) });
  } catch (error) {
    self.postMessage({ id, error: error.message, isKnead: error instanceof knead.KneadError });
  }
};
