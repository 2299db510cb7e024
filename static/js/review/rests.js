// @ts-check
/**
 * Requests that have failed rest before they are made again: longer each time, and for good where there is no such thing.
 * What tells of a failure changes the state, and each change asks for what is missing, so without a rest a page would
 * ask as fast as it can.
 */

/** The first rest and the longest, ms. */
const SHORTEST = 500;
const LONGEST = 30_000;

/**
 * @typedef {object} Rests
 * @property {(name: string) => boolean} has      whether a request rests
 * @property {(name: string) => number} failed    begin or lengthen its rest; how long, ms
 * @property {(name: string) => void} absent      it is not worth asking again
 * @property {(name: string) => void} done        it has come
 * @property {() => void} clear
 */

/**
 * @param {() => number} [now]   ms
 * @returns {Rests}
 */
export function createRests(now = Date.now) {
  /** @type {Map<string, {until: number, pause: number}>} */
  const resting = new Map();
  return {
    has: (name) => (resting.get(name)?.until ?? -Infinity) > now(),
    failed(name) {
      const pause = Math.min(LONGEST, 2 * (resting.get(name)?.pause ?? SHORTEST / 2));
      resting.set(name, { until: now() + pause, pause });
      return pause;
    },
    absent: (name) => void resting.set(name, { until: Infinity, pause: LONGEST }),
    done: (name) => void resting.delete(name),
    clear: () => resting.clear(),
  };
}
