// @ts-check
/** The keys of every list: which item is next. Pure. */

/**
 * @param {string} key       of the keyboard
 * @param {number} at        place now; -1: none, then the first one is next, or the last one after End
 * @param {number} count     items
 * @param {object} list
 * @param {number} list.page         rows on the screen
 * @param {number} [list.columns]    of a grid, where left and right lead to the next item
 * @param {boolean} [list.typed]     the focus is in a field of text: Home and End are its own
 * @returns {number|null} null: the key leads nowhere
 */
export function stepTo(key, at, count, { page, columns: across, typed = false }) {
  const columns = across ?? 1;
  /** @type {Record<string, number>} */
  const steps = {
    ArrowUp: -columns,
    ArrowDown: columns,
    PageUp: -columns * page,
    PageDown: columns * page,
    ...(across !== undefined && { ArrowLeft: -1, ArrowRight: 1 }),
    ...(!typed && { Home: -count, End: count }),
  };
  const step = steps[key];
  if (step === undefined || count === 0) return null;
  if (at < 0) return key === 'End' ? count - 1 : 0;
  const next = at + step;
  // up from the first row and down from the last one lead nowhere; a page leads to the end
  if (
    (key === 'ArrowUp' && next < 0) ||
    (key === 'ArrowDown' && next >= count && Math.floor(at / columns) === Math.floor((count - 1) / columns))
  )
    return at;
  return Math.max(0, Math.min(count - 1, next));
}
