// @ts-check
/** The shape of a comparison, as app/compare sends it. Types only. */

/**
 * The box that a place is about, and what the other side has there: its partner, else what overlaps it most.
 *
 * @typedef {object} Pair
 * @property {import('../types.js').Box} box
 * @property {number} label                      -1: none of the set's labels
 * @property {string|null} other                 track of the other side; null: nothing overlaps the box
 * @property {import('../types.js').Box|null} other_box
 * @property {number|null} other_label
 * @property {number} iou
 */

/**
 * One number and the places behind it: frames `frames[i]` to `lasts[i]` of track `tracks[i]`, which the other side calls
 * `partners[i]`; null: it has nothing there.
 *
 * @typedef {object} Figure
 * @property {number|null} value                 null: nothing to measure
 * @property {[number, number]|null} of          numerator and denominator, for shares
 * @property {number[]} frames
 * @property {number[]} lasts
 * @property {string[]} tracks
 * @property {(string|null)[]} partners
 * @property {number} places                     their full number, also where the lists are cut
 * @property {Pair[]} pairs                      both boxes in the first frame of each place
 * @property {number[]|null} errors              how large the error is in each place, where they are in its order
 */

/**
 * @typedef {object} Cell
 * @property {number|null} reference             null: no sign there; -1: one of none of the classes
 * @property {number|null} candidate             null: missed; -1: found, and called none of the classes
 * @property {number} count                      boxes
 * @property {number[]} frames
 * @property {number[]} lasts
 * @property {string[]} tracks
 * @property {(string|null)[]} partners
 * @property {Pair[]} pairs
 */

/**
 * @typedef {object} Comparison
 * @property {string} video_id
 * @property {number} width                      of the video's picture, px
 * @property {number} height
 * @property {string} reference
 * @property {string} candidate
 * @property {{reference: Side, candidate: Side}} sides
 * @property {number} first                      frames that both have
 * @property {number} last
 * @property {Record<string, Figure>} figures
 * @property {{classes: number[], words?: Record<string, string>, cells: Cell[]}} confusion   `words`: what models call signs that the set lacks, by a number from -10 down
 */

/** @typedef {{name: string, kind: string, tracks: number, boxes: number, names: Record<string, string>, edited: boolean}} Side   names: of tracks that people have made, by key; edited: a run on which people have said something */
/** @typedef {{title: string, frames: number[], lasts: number[], tracks: string[], partners: (string|null)[], pairs: Pair[], places: number, errors?: number[]|null, side: 'reference'|'candidate'}} Places */
/** @typedef {{changed: number, made: number, same: number, op_id: string|null, repaired: string[], skipped: string[]}} TakenOver   op_id: null: nothing has changed */
export {};
