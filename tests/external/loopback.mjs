// A folder of this machine, served on the loopback interface only: CesiumJS reads resources by url.
import http from "node:http";
import { readFile } from "node:fs/promises";
import path from "node:path";

/**
 * Serve the files of one folder.
 *
 * @param {string} folder folder on this machine
 * @returns {Promise<{url: string, missing: string[], close: () => void}>} base url with a slash at its end, the
 *   requests that found no file, and the way to stop
 */
export async function serveFolder(folder) {
  const root = path.resolve(folder);
  const missing = [];
  const server = http.createServer(async (request, response) => {
    const name = decodeURIComponent(new URL(request.url, "http://localhost").pathname);
    const file = path.join(root, name);
    try {
      if (!file.startsWith(root + path.sep)) throw new Error("outside the folder");
      response.end(await readFile(file));
    } catch {
      missing.push(name);
      response.statusCode = 404;
      response.end();
    }
  });
  await new Promise((started) => server.listen(0, "127.0.0.1", started));
  return {
    url: `http://127.0.0.1:${server.address().port}/`,
    missing,
    close: () => server.close(),
  };
}
