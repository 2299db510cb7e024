// @ts-check
/** The shape of a comparison, as `app/compare` sends it. Types only. */

/**
 * The box at a place, and the other side's box there: its partner, else the box with the largest overlap.
 *
 * @typedef {object} Pair
 * @property {import('../types.js').Box} box
 * @property {number} label                      -1: none of the set's labels
 * @property {string|null} other                 track of the other side; null: no box overlaps
 * @property {import('../types.js').Box|null} other_box
 * @property {number|null} other_label
 * @property {number} iou
 */

/**
 * One number and its places: frames `frames[i]` to `lasts[i]` of track `tracks[i]`, whose partner on the other side is
 * track `partners[i]`; null: no partner.
 *
 * @typedef {object} Figure
 * @property {number|null} value                 null: nothing to measure
 * @property {[number, number]|null} of          numerator and denominator, for shares
 * @property {number[]} frames
 * @property {number[]} lasts
 * @property {string[]} tracks
 * @property {(string|null)[]} partners
 * @property {number} places                     total number, also if the lists are truncated
 * @property {Pair[]} pairs                      the boxes in the first frame of each place
 * @property {number[]|null} errors              size of the error at each place, if the places are sorted by it
 */

/**
 * @typedef {object} Cell
 * @property {number|null} reference             null: no sign; -1: a sign of none of the classes
 * @property {number|null} candidate             null: missed; -1: found, but with none of the classes
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
 * @property {number} width                      of the video, px
 * @property {number} height
 * @property {string} reference
 * @property {string} candidate
 * @property {{reference: Side, candidate: Side}} sides
 * @property {number} first                      first frame that both sides have
 * @property {number} last
 * @property {Record<string, Figure>} figures
 * @property {{classes: number[], words?: Record<string, string>, cells: Cell[]}} confusion   `words`: models' names for signs that the label set lacks, by number (-10 and below)
 */

/** @typedef {{name: string, kind: string, tracks: number, boxes: number, names: Record<string, string>, edited: boolean}} Side   names: of tracks that people made, by key; edited: a run with corrections or verdicts */
/** @typedef {{title: string, frames: number[], lasts: number[], tracks: string[], partners: (string|null)[], pairs: Pair[], places: number, errors?: number[]|null, side: 'reference'|'candidate'}} Places */
/** @typedef {{changed: number, made: number, same: number, op_id: string|null, repaired: string[], skipped: string[]}} TakenOver   op_id null: nothing changed */
export {};
