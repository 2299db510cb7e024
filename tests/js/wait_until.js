// @ts-check
/** Waits that a slow machine cannot cut short. */
import assert from 'node:assert/strict';

/**
 * Wait until something holds or is found.
 * @template T
 * @param {() => T} condition
 * @param {number} [timeoutMs]   ms
 * @returns {Promise<NonNullable<T>>}   what was found
 */
export async function waitUntil(condition, timeoutMs = 20_000) {
  const deadline = performance.now() + timeoutMs;
  for (;;) {
    const found = condition();
    if (found) return found;
    assert.ok(performance.now() < deadline, `still not so after ${timeoutMs} ms: ${condition}`);
    await new Promise((resolve) => setTimeout(resolve, 5));
  }
}

/**
 * Let the timers of 1 ms run a number of times, one after the other. A wait of so many milliseconds would end before
 * them if the process did nothing for a moment.
 * @param {number} [count]
 */
export async function runTimers(count = 20) {
  for (let i = 0; i < count; i += 1) await new Promise((resolve) => setTimeout(resolve, 1));
}

/** Let pending promises and short timers run. */
export const tick = () => new Promise((resolve) => setTimeout(resolve, 2));
