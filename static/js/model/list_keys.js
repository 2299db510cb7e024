// @ts-check
/** Keyboard navigation in lists: the next item for a key. Pure. */

/**
 * @param {string} key       of the keyboard
 * @param {number} index        the present index; -1: none, so that the first item is next, or the last one for End
 * @param {number} count     items
 * @param {object} list
 * @param {number} list.page         rows per page
 * @param {number} [list.columns]    columns of a grid, in which left and right move by one item
 * @param {boolean} [list.isInTextField]     the focus is in a text field, which keeps Home and End
 * @returns {number|null} null: the key does not move
 */
export function nextIndex(key, index, count, { page, columns: across, isInTextField = false }) {
  const columns = across ?? 1;
  /** @type {Record<string, number>} */
  const steps = {
    ArrowUp: -columns,
    ArrowDown: columns,
    PageUp: -columns * page,
    PageDown: columns * page,
    ...(across !== undefined && { ArrowLeft: -1, ArrowRight: 1 }),
    ...(!isInTextField && { Home: -count, End: count }),
  };
  const step = steps[key];
  if (step === undefined || count === 0) return null;
  if (index < 0) return key === 'End' ? count - 1 : 0;
  const next = index + step;
  // no move up from the first row or down from the last one; a page moves to the end at most
  if (
    (key === 'ArrowUp' && next < 0) ||
    (key === 'ArrowDown' && next >= count && Math.floor(index / columns) === Math.floor((count - 1) / columns))
  )
    return index;
  return Math.max(0, Math.min(count - 1, next));
}
