// @ts-check
/** The shape of a comparison, as app/compare sends it. Types only. */

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
 */

/**
 * @typedef {object} Comparison
 * @property {string} video_id
 * @property {string} reference
 * @property {string} candidate
 * @property {{reference: Side, candidate: Side}} sides
 * @property {number} first                      frames that both have
 * @property {number} last
 * @property {Record<string, Figure>} figures
 * @property {{classes: number[], words?: Record<string, string>, cells: Cell[]}} confusion   `words`: what models call signs that the set lacks, by a number from -10 down
 */

/** @typedef {{name: string, kind: string, tracks: number, boxes: number, names: Record<string, string>, edited: boolean}} Side   names: of tracks that people have made, by key; edited: a run on which people have said something */
/** @typedef {{title: string, frames: number[], lasts: number[], tracks: string[], partners: (string|null)[], places: number, errors?: number[]|null, side: 'reference'|'candidate'}} Places */
export {};
