// Serves a folder on this machine: node serve.mjs FOLDER [PORT]. Pages get the headers that threads need, and may load
// nothing from elsewhere.
import { createServer } from 'node:http';
import { readFile, stat } from 'node:fs/promises';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const types = {
  '.html': 'text/html; charset=utf-8',
  '.js': 'text/javascript; charset=utf-8',
  '.mjs': 'text/javascript; charset=utf-8',
  '.css': 'text/css; charset=utf-8',
  '.wasm': 'application/wasm',
  '.svg': 'image/svg+xml',
  '.png': 'image/png',
  '.json': 'application/json',
  '.webmanifest': 'application/manifest+json',
};

const plainHeaders = { 'Cache-Control': 'no-cache', 'X-Content-Type-Options': 'nosniff' };
const threadHeaders = {
  ...plainHeaders,
  'Cross-Origin-Opener-Policy': 'same-origin',
  'Cross-Origin-Embedder-Policy': 'require-corp',
};

async function answer(folder, headers, request, response) {
  const { pathname } = new URL(request.url, 'http://localhost');
  let file = path.join(folder, path.normalize(decodeURIComponent(pathname)));
  if ((await stat(file)).isDirectory()) file = path.join(file, 'index.html');
  const bytes = await readFile(file);
  response.writeHead(200, { ...headers, 'Content-Type': types[path.extname(file)] ?? 'application/octet-stream' });
  response.end(bytes);
}

// Returns the server once it listens; port 0: any that is free. Tests also serve without the headers for threads.
export function serve(folder, port = 0, allowsThreads = true) {
  const headers = allowsThreads ? threadHeaders : plainHeaders;
  const server = createServer((request, response) => {
    answer(folder, headers, request, response).catch(() => {
      response.writeHead(404, headers);
      response.end('not found\n');
    });
  });
  return new Promise((resolve, reject) => {
    server.once('error', reject);
    server.listen(port, '127.0.0.1', () => resolve(server));
  });
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [folder, port = '8000'] = process.argv.slice(2);
  try {
    const server = await serve(folder, Number(port));
    console.log(`http://localhost:${server.address().port}/ shows ${folder}; Ctrl-C ends it`);
  } catch (error) {
    console.error(`serve: port ${port}: ${error.message}; give another port`);
    process.exitCode = 1;
  }
}
