// What CesiumJS sees in a tileset: `node cesium_load.mjs TILESET.json` prints one JSON object.
//
// CesiumJS is run without a picture: the tileset, its external tilesets and every glTF content are read by its own
// loaders into memory. Positions are taken to the world as its renderer would take them (tile transform after the
// y-up to z-up turn) and compared with the volume by which it would cull the tile.
import path from "node:path";
import { serveFolder } from "./loopback.mjs";

// The loaders ask once whether the browser shows WebP pictures. There is no browser: the answer is no.
globalThis.Image = class {
  set src(_) {
    queueMicrotask(() => this.onerror());
  }
};
const Cesium = await import("cesium");

const NAV = "3DTILES_nav";
const FRAME_STATE = { context: { webgl2: true, supportedImageFormats: { webp: false, basis: false } }, afterRender: [] };
const LIMIT_MS = 60_000;

/** Read one glTF by the loader of CesiumJS; arrays instead of GPU buffers. */
async function loadGltf(resource) {
  const loader = new Cesium.GltfLoader({
    gltfResource: resource,
    upAxis: Cesium.Axis.Y,
    forwardAxis: Cesium.Axis.X,
    incrementallyLoadTextures: false,
    loadAttributesAsTypedArray: true,
  });
  await loader.load();
  const deadline = Date.now() + LIMIT_MS;
  while (!loader.process(FRAME_STATE)) {
    if (Date.now() > deadline) throw new Error(`${resource.url}: not loaded after ${LIMIT_MS} ms`);
    await new Promise((later) => setTimeout(later, 1));
  }
  return loader.components;
}

function* primitivesOf(node, parent) {
  const local = Cesium.Matrix4.multiplyTransformation(parent, Cesium.ModelUtility.getNodeTransform(node), new Cesium.Matrix4());
  for (const primitive of node.primitives ?? []) yield [primitive, local];
  for (const child of node.children ?? []) yield* primitivesOf(child, local);
}

/** Counts of a content, and by how far its positions leave the sphere around the tile's volume. */
function measure(components, tile) {
  const facts = { triangles: 0, primitives: 0, outside: 0 };
  const sphere = tile.boundingSphere;
  const point = new Cesium.Cartesian3();
  const world = Cesium.Matrix4.multiplyTransformation(tile.computedTransform, Cesium.Axis.Y_UP_TO_Z_UP, new Cesium.Matrix4());
  for (const root of components.scene.nodes) {
    for (const [primitive, transform] of primitivesOf(root, world)) {
      const positions = primitive.attributes.find((one) => one.semantic === "POSITION");
      const indices = primitive.indices;
      facts.primitives += 1;
      facts.triangles += (indices ? indices.count : positions.count) / 3;
      for (let i = 0; i < positions.count; i++) {
        Cesium.Cartesian3.unpack(positions.typedArray, 3 * i, point);
        Cesium.Matrix4.multiplyByPoint(transform, point, point);
        facts.outside = Math.max(facts.outside, Cesium.Cartesian3.distance(point, sphere.center) - sphere.radius);
      }
    }
  }
  return facts;
}

async function walk(tile, base, found) {
  const header = tile._header;
  const uri = header.content?.uri;
  if (uri?.endsWith(".json")) {
    const inner = await Cesium.Cesium3DTileset.fromUrl(new URL(uri, base).href);
    found.externalTilesets += 1;
    await walk(inner.root, new URL(uri, base).href, found);
  } else if (uri) {
    const components = await loadGltf(new Cesium.Resource({ url: new URL(uri, base).href }));
    const replaced = tile.refine === Cesium.Cesium3DTileRefine.REPLACE && tile.children.length > 0;
    const nav = header.content.extensions?.[NAV] ?? null;
    found.contents.push({ uri, nav, error: tile.geometricError, replaced, ...measure(components, tile) });
  }
  for (const child of tile.children) await walk(child, base, found);
}

const file = path.resolve(process.argv[2]);
const served = await serveFolder(path.dirname(file));
try {
  const url = served.url + encodeURIComponent(path.basename(file));
  const tileset = await Cesium.Cesium3DTileset.fromUrl(url);
  const found = {
    cesium: Cesium.VERSION,
    asset: tileset.asset,
    nav: tileset.extensions?.[NAV] ?? null,
    externalTilesets: 0,
    contents: [],
    missing: served.missing,
  };
  await walk(tileset.root, url, found);
  process.stdout.write(JSON.stringify(found) + "\n");
} finally {
  served.close();
}
