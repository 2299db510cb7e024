// @ts-check

/** Gives the page a storage of its own while one test runs. @param {import('node:test').TestContext} t */
export function withStorage(t) {
  /** @type {Map<string, string>} */
  const stored = new Map();
  Object.defineProperty(globalThis, 'localStorage', {
    configurable: true,
    value: {
      getItem: (/** @type {string} */ name) => stored.get(name) ?? null,
      setItem: (/** @type {string} */ name, /** @type {string} */ value) => stored.set(name, value),
    },
  });
  t.after(() => Reflect.deleteProperty(globalThis, 'localStorage'));
}
