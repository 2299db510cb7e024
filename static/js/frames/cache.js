// @ts-check
/**
 * Decoded pictures by ordinal, bounded by their bytes. A picture is only ever handed out for the ordinal that the
 * server says it has.
 *
 * @typedef {{frame: number, width: number, bitmap: ImageBitmap}} Shot   width: the one asked for; 0: a soft stand-in
 */

const MOST_BYTES = 384 * 2 ** 20;
const AT_ONCE = 5;

/**
 * @typedef {object} FrameCache
 * @property {(frame: number) => Shot|null} peek           what is there at once
 * @property {(frame: number) => Promise<Shot>} load       from the server if need be; an older load gives way at the next `want`
 * @property {(frame: number) => Promise<Shot>} preview     the same, or a soft stand-in where that is there sooner
 * @property {(frames: Iterable<number>) => void} want     load these ahead, in order; what is not among them is dropped.
 *     Nothing is loaded ahead while pictures that were asked for fail
 * @property {(width: number) => void} setWidth            width that pictures are wanted at, px
 * @property {() => void} clear                            the end: nothing is loaded any more
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
  /** The frame that was asked for last: it goes before all prefetching. */
  let urgent = -1;
  let closed = false;
  /** The last answer was a failure: the file may be gone, and then every picture ahead would fail too. */
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
    held.delete(frame); // used last
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
        running.delete(frame); // whoever asks for it again starts anew
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
