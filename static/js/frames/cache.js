// @ts-check
/**
 * Decoded pictures by ordinal, limited by their size in bytes. A picture is returned only for the ordinal that the
 * server reports for it.
 *
 * @typedef {{frame: number, width: number, bitmap: ImageBitmap}} Shot   width: the requested one, px; 0: a soft preview
 */

const MOST_BYTES = 384 * 2 ** 20;
const AT_ONCE = 5;

/**
 * @typedef {object} FrameCache
 * @property {(frame: number) => Shot|null} peek           the cached picture; null: none
 * @property {(frame: number) => Promise<Shot>} load       from the cache, else from the server; the next `want` cancels older loads
 * @property {(frame: number) => Promise<Shot>} preview     the same, or a soft preview if that is available sooner
 * @property {(frames: Iterable<number>) => void} want     load these frames ahead, in order, and cancel the loading of
 *   others. Nothing is loaded ahead while requested pictures fail
 * @property {(width: number) => void} setWidth            sets the width of requested pictures, px
 * @property {() => void} clear                            empties the cache and ends all loading
 */

/**
 * @param {import('../api/client.js').Api} api
 * @param {string} video
 * @param {{most?: number, decode?: (blob: Blob) => Promise<ImageBitmap>}} [options]
 * @returns {FrameCache}
 */
export function createFrameCache(api, video, { most = MOST_BYTES, decode = (blob) => createImageBitmap(blob) } = {}) {
  /** @type {Map<number, Shot>} */
  const held = new Map();
  /** @type {Map<number, {promise: Promise<Shot>, abort: AbortController, preview: boolean}>} */
  const running = new Map();
  /** @type {number[]} */
  let queue = [];
  let bytes = 0;
  let width = 1280;
  /** The frame that was requested last; it is loaded before prefetched ones. */
  let urgent = -1;
  let closed = false;
  /** Whether the last answer was a failure: the file may be missing, and then every prefetch would fail too. */
  let failing = false;

  /** @param {Shot} shot */
  const sizeOf = (shot) => shot.bitmap.width * shot.bitmap.height * 4;

  /** @param {Shot} shot */
  function keep(shot) {
    drop(shot.frame);
    held.set(shot.frame, shot);
    bytes += sizeOf(shot);
    for (const frame of held.keys()) {
      if (bytes <= most || held.size <= 2) break;
      if (frame !== shot.frame) drop(frame);
    }
  }

  /** @param {number} frame */
  function drop(frame) {
    const shot = held.get(frame);
    if (!shot) return;
    bytes -= sizeOf(shot);
    held.delete(frame);
    shot.bitmap.close();
  }

  /** @param {number} frame @param {boolean} [preview] */
  function start(frame, preview = false) {
    const known = running.get(frame);
    if (known && (preview || !known.preview)) return known.promise;
    known?.abort.abort();
    const abort = new AbortController();
    const asked = width;
    const promise = (async () => {
      const { blob, ordinal, exact } = await api.frame(video, frame, { width: asked, preview, signal: abort.signal });
      if (abort.signal.aborted) throw new DOMException('The picture is no longer wanted.', 'AbortError');
      if (ordinal !== frame) throw new Error(`Asked for frame ${frame}, got ${ordinal}.`);
      const shot = { frame, width: exact ? asked : 0, bitmap: await decode(blob) };
      if (closed) {
        shot.bitmap.close();
        throw new DOMException('The page has gone on.', 'AbortError');
      }
      keep(shot);
      failing = false;
      return shot;
    })()
      .catch((error) => {
        if (!abort.signal.aborted && !closed) {
          failing = true;
          queue = [];
        }
        throw error;
      })
      .finally(() => {
        if (running.get(frame)?.abort === abort) running.delete(frame);
        pump();
      });
    promise.catch(() => {});
    running.set(frame, { promise, abort, preview });
    return promise;
  }

  function pump() {
    while (queue.length && running.size < AT_ONCE) {
      const frame = /** @type {number} */ (queue.shift());
      if (!fresh(frame)) start(frame);
    }
  }

  /** @param {number} frame */
  function fresh(frame) {
    const shot = held.get(frame);
    if (!shot || shot.width < width) return null;
    held.delete(frame); // moves it to the end: used most recently
    held.set(frame, shot);
    return shot;
  }

  return {
    peek: (frame) => fresh(frame) ?? held.get(frame) ?? null,
    load: (frame) => {
      urgent = frame;
      const shot = fresh(frame);
      return shot ? Promise.resolve(shot) : start(frame);
    },
    preview: (frame) => {
      urgent = frame;
      const shot = fresh(frame);
      return shot ? Promise.resolve(shot) : start(frame, true);
    },
    want(frames) {
      const wanted = new Set(frames);
      for (const [frame, request] of running) {
        if (frame === urgent || wanted.has(frame)) continue;
        running.delete(frame); // the next request starts a new load
        request.abort.abort();
      }
      queue = failing ? [] : [...wanted].filter((frame) => !fresh(frame) && !running.has(frame));
      pump();
    },
    setWidth(wanted) {
      width = wanted;
    },
    clear() {
      closed = true;
      queue = [];
      for (const request of running.values()) request.abort.abort();
      running.clear();
      for (const frame of [...held.keys()]) drop(frame);
    },
  };
}
