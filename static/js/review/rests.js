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
 * @property {(name: string, again: () => void) => void} failed   begin or lengthen its wait, and call back when it ends
 * @property {(name: string) => void} absent      never repeat the request
 * @property {(name: string) => void} done        the request has succeeded
 * @property {() => void} clear                   end all waits; nobody is called back early
 */

/** @returns {Rests} */
export function createRests() {
  /** @type {Map<string, {over: boolean, pause: number}>} */
  const resting = new Map();
  return {
    has: (name) => resting.get(name)?.over === false,
    failed(name, again) {
      const pause = Math.min(LONGEST, 2 * (resting.get(name)?.pause ?? SHORTEST / 2));
      const rest = { over: false, pause };
      resting.set(name, rest);
      // the timer alone ends the wait: another clock may still see it run when the timer fires
      setTimeout(() => {
        rest.over = true;
        again();
      }, pause);
    },
    absent: (name) => void resting.set(name, { over: false, pause: LONGEST }),
    done: (name) => void resting.delete(name),
    clear: () => resting.clear(),
  };
}
