// @ts-check
/**
 * Decoded pictures by ordinal, limited by their size in bytes. A picture is returned only for the ordinal that the
 * server reports for it.
 *
 * @typedef {{frame: number, width: number, bitmap: ImageBitmap}} Picture   width: the requested one, px; 0: a soft preview
 */

const MAX_BYTES = 384 * 2 ** 20;
const MAX_CONCURRENT_LOADS = 5;

/**
 * @typedef {object} FrameCache
 * @property {(frame: number) => Picture|null} peek           the cached picture; null: none
 * @property {(frame: number) => Promise<Picture>} load       from the cache, else from the server; the next `want` cancels older loads
 * @property {(frame: number) => Promise<Picture>} preview     the same, or a soft preview if that is available sooner
 * @property {(frames: Iterable<number>) => void} prefetch     load these frames ahead, in order, and cancel the loading of
 *   others. Nothing is loaded ahead while requested pictures fail
 * @property {(width: number) => void} setWidth            sets the width of requested pictures, px
 * @property {() => void} clear                            empties the cache and ends all loading
 */

/**
 * @param {import('../api/client.js').Api} api
 * @param {string} video
 * @param {{maxBytes?: number, decode?: (blob: Blob) => Promise<ImageBitmap>}} [options]
 * @returns {FrameCache}
 */
export function createFrameCache(api, video, { maxBytes = MAX_BYTES, decode = (blob) => createImageBitmap(blob) } = {}) {
  /** @type {Map<number, Picture>} */
  const pictures = new Map();
  /** Pending loads. A load of a preview has the width 0. @type {Map<number, {promise: Promise<Picture>, abort: AbortController, width: number}>} */
  const loads = new Map();
  /** @type {number[]} */
  let queue = [];
  let bytes = 0;
  let width = 1280;
  /** The frame that was requested last; it is loaded before prefetched ones. */
  let urgent = -1;
  let closed = false;
  /** Whether the last answer was a failure: the file may be missing, and then every prefetch would fail too. */
  let failing = false;

  /** @param {Picture} picture */
  const sizeOf = (picture) => picture.bitmap.width * picture.bitmap.height * 4;

  /** @param {Picture} picture */
  function add(picture) {
    evict(picture.frame);
    pictures.set(picture.frame, picture);
    bytes += sizeOf(picture);
    for (const frame of pictures.keys()) {
      if (bytes <= maxBytes || pictures.size <= 2) break;
      if (frame !== picture.frame) evict(frame);
    }
  }

  /** @param {number} frame */
  function evict(frame) {
    const picture = pictures.get(frame);
    if (!picture) return;
    bytes -= sizeOf(picture);
    pictures.delete(frame);
    picture.bitmap.close();
  }

  /** @param {number} frame @param {boolean} [preview] */
  function startLoad(frame, preview = false) {
    const known = loads.get(frame);
    const requestedWidth = width;
    const loadWidth = preview ? 0 : requestedWidth;
    if (known && known.width >= loadWidth) return known.promise;
    known?.abort.abort();
    const abort = new AbortController();
    const promise = (async () => {
      const { blob, ordinal, exact } = await api.frame(video, frame, { width: requestedWidth, preview, signal: abort.signal });
      if (abort.signal.aborted) throw new DOMException('The picture is no longer wanted.', 'AbortError');
      if (ordinal !== frame) throw new Error(`Asked for frame ${frame}, got ${ordinal}.`);
      const picture = { frame, width: exact ? requestedWidth : 0, bitmap: await decode(blob) };
      if (closed) {
        picture.bitmap.close();
        throw new DOMException('The page has gone on.', 'AbortError');
      }
      add(picture);
      failing = false;
      return picture;
    })()
      .catch((error) => {
        if (!abort.signal.aborted && !closed) {
          failing = true;
          queue = [];
        }
        throw error;
      })
      .finally(() => {
        if (loads.get(frame)?.abort === abort) loads.delete(frame);
        startQueued();
      });
    promise.catch(() => {});
    loads.set(frame, { promise, abort, width: loadWidth });
    return promise;
  }

  function startQueued() {
    while (queue.length && loads.size < MAX_CONCURRENT_LOADS) {
      const frame = /** @type {number} */ (queue.shift());
      if (!sharpPicture(frame)) startLoad(frame);
    }
  }

  /** @param {number} frame */
  function sharpPicture(frame) {
    const picture = pictures.get(frame);
    if (!picture || picture.width < width) return null;
    pictures.delete(frame); // moves it to the end: used most recently
    pictures.set(frame, picture);
    return picture;
  }

  return {
    peek: (frame) => sharpPicture(frame) ?? pictures.get(frame) ?? null,
    load: (frame) => {
      urgent = frame;
      const picture = sharpPicture(frame);
      return picture ? Promise.resolve(picture) : startLoad(frame);
    },
    preview: (frame) => {
      urgent = frame;
      const picture = sharpPicture(frame);
      return picture ? Promise.resolve(picture) : startLoad(frame, true);
    },
    prefetch(frames) {
      const wanted = new Set(frames);
      for (const [frame, request] of loads) {
        if (frame === urgent || wanted.has(frame)) continue;
        loads.delete(frame); // the next request starts a new load
        request.abort.abort();
      }
      queue = failing ? [] : [...wanted].filter((frame) => !sharpPicture(frame) && !loads.has(frame));
      startQueued();
    },
    setWidth(wanted) {
      width = wanted;
    },
    clear() {
      closed = true;
      queue = [];
      for (const request of loads.values()) request.abort.abort();
      loads.clear();
      for (const frame of [...pictures.keys()]) evict(frame);
    },
  };
}
