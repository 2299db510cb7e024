// @ts-check
/**
 * The outbox of the person who is signed in. Several people can use one browser: another person's unsaved edits wait
 * until that person signs in, and are neither sent nor counted until then.
 */

/**
 * @param {import('./outbox.js').Outbox} outbox
 * @param {Promise<unknown>} personKnown   resolves when it is known who is signed in
 * @param {() => string|null} person   null: the library has no people, and all edits belong to the user
 * @returns {import('./outbox.js').Outbox}
 */
export function createUserOutbox(outbox, personKnown, person) {
  /** @param {import('./outbox.js').Pending[]} found */
  const ofUser = (found) => {
    const name = person();
    return name === null ? found : found.filter(({ author }) => author === name);
  };
  return {
    ...outbox,
    all: async () => (await personKnown, ofUser(await outbox.all())),
    load: async (run) => (await personKnown, ofUser(await outbox.load(run))),
  };
}
