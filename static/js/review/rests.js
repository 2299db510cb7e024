// @ts-check
/**
 * Waiting times of failed requests: longer after each failure, and for ever if the server does not have the thing. A
 * report of a failure changes the state, and each change of the state requests what is missing, so without waiting a
 * page would repeat requests as fast as it can.
 */

/** The first wait and the longest, ms. */
const SHORTEST = 500;
const LONGEST = 30_000;

/**
 * @typedef {object} Rests
 * @property {(name: string) => boolean} has      whether a request has to wait
 * @property {(name: string) => number} failed    begin or lengthen its wait; returns the wait, ms
 * @property {(name: string) => void} absent      never repeat the request
 * @property {(name: string) => void} done        the request has succeeded
 * @property {() => void} clear
 */

/**
 * @param {() => number} [now]   ms; a clock that nobody sets
 * @returns {Rests}
 */
export function createRests(now = () => performance.now()) {
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
