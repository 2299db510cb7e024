// @ts-check
/**
 * A promise that is settled from outside.
 * @returns {{promise: Promise<any>, resolve: (value?: any) => void, reject: (reason: unknown) => void}}
 */
export function deferred() {
  /** @type {(value?: any) => void} */
  let resolve = () => {};
  /** @type {(reason: unknown) => void} */
  let reject = () => {};
  const promise = new Promise((resolvePromise, rejectPromise) => {
    resolve = resolvePromise;
    reject = rejectPromise;
  });
  return { promise, resolve, reject };
}
