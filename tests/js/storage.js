// @ts-check

/** Gives the page a storage of its own while one test runs. @param {import('node:test').TestContext} t */
export function withStorage(t) {
  /** @type {Map<string, string>} */
  const kept = new Map();
  Object.defineProperty(globalThis, 'localStorage', {
    configurable: true,
    value: {
      getItem: (/** @type {string} */ name) => kept.get(name) ?? null,
      setItem: (/** @type {string} */ name, /** @type {string} */ value) => kept.set(name, value),
    },
  });
  t.after(() => Reflect.deleteProperty(globalThis, 'localStorage'));
}
