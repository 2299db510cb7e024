// @ts-check
/**
 * A promise that is settled from outside.
 * @returns {{promise: Promise<any>, release: (value?: any) => void, refuse: (reason: unknown) => void}}
 */
export function held() {
  /** @type {(value?: any) => void} */
  let release = () => {};
  /** @type {(reason: unknown) => void} */
  let refuse = () => {};
  const promise = new Promise((resolve, reject) => {
    release = resolve;
    refuse = reject;
  });
  return { promise, release, refuse };
}
