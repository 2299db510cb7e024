// @ts-check

/**
 * A drawing context without a picture.
 * @param {(name: string, args: any[]) => void} onCall   called for each method
 * @param {number} [textWidth]   width of every text, px
 * @returns {any}
 */
export const fakeContext = (onCall, textWidth = 20) =>
  new Proxy(
    {},
    {
      get:
        (_, name) =>
        (/** @type {any[]} */ ...args) => {
          onCall(String(name), args);
          return { width: textWidth };
        },
      set: () => true,
    },
  );
