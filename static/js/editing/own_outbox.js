// @ts-check
/**
 * The outbox of who is signed in. Several people can use one browser: what another has not saved yet waits until that
 * person signs in, and is neither sent nor counted until then.
 */

/**
 * @param {import('./outbox.js').Outbox} outbox
 * @param {Promise<unknown>} known   ends when the server has said who is signed in
 * @param {() => string|null} person   null: the library has no people, all edits are one's own
 * @returns {import('./outbox.js').Outbox}
 */
export function createOwnOutbox(outbox, known, person) {
  /** @param {import('./outbox.js').Pending[]} found */
  const own = (found) => {
    const name = person();
    return name === null ? found : found.filter(({ author }) => author === name);
  };
  return {
    ...outbox,
    all: async () => (await known, own(await outbox.all())),
    load: async (run) => (await known, own(await outbox.load(run))),
  };
}
