// @ts-check
/**
 * Exponential backoff of failed requests. A request for a missing thing is never repeated. A report of a failure changes
 * the state, and each change of the state requests what is missing, so without delays a page would repeat requests as
 * fast as it can.
 */

const MIN_DELAY_MS = 500;
const MAX_DELAY_MS = 30_000;

/**
 * @typedef {object} RetryDelays
 * @property {(name: string) => boolean} isWaiting  whether a request must not be repeated yet
 * @property {(name: string, retry: () => void) => void} failed   double its delay, and call `retry` when the delay is over
 * @property {(name: string) => void} missing    never repeat the request
 * @property {(name: string) => void} succeeded  forget its failures
 * @property {() => void} clear                     end all delays; their timers still call `retry`
 */

/** @returns {RetryDelays} */
export function createRetryDelays() {
  /** @type {Map<string, {isOver: boolean, delay: number}>} */
  const waits = new Map();
  return {
    isWaiting: (name) => waits.get(name)?.isOver === false,
    failed(name, retry) {
      const delay = Math.min(MAX_DELAY_MS, 2 * (waits.get(name)?.delay ?? MIN_DELAY_MS / 2));
      const wait = { isOver: false, delay };
      waits.set(name, wait);
      // the timer alone ends the delay: another clock may still see it run when the timer fires
      setTimeout(() => {
        wait.isOver = true;
        retry();
      }, delay);
    },
    missing: (name) => void waits.set(name, { isOver: false, delay: MAX_DELAY_MS }),
    succeeded: (name) => void waits.delete(name),
    clear: () => waits.clear(),
  };
}
