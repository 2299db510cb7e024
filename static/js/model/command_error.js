// @ts-check
/** The error of a command that cannot be applied. */

/** A command that is not possible on the documents; the message is one sentence. */
export class CommandError extends Error {
  /** @param {string} message */
  constructor(message) {
    super(message);
    this.name = 'CommandError';
  }
}

/**
 * @template T
 * @param {T|null|undefined} value
 * @param {string} name
 * @returns {T}
 */
export function requireValue(value, name) {
  if (value === null || value === undefined) throw new CommandError(`The command needs a ${name}.`);
  return value;
}
