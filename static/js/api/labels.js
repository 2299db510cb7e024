// @ts-check
/** Routes of label sets. */

import { encode } from './http.js';
import { expectList, expectObject } from './shapes.js';

/** @typedef {import('../types.js').LabelSetSummary} LabelSetHead */
/** @typedef {{signal?: AbortSignal, timeout?: number}} Call */
/** @typedef {{version: number, label: import('../types.js').Label|null, sentence: string}} LabelAnswer   `label`: the changed label */
/** @typedef {ReturnType<typeof labelRoutes>} LabelRoutes */
/** @typedef {{version: number, sentence: string, created: boolean, added: unknown[], known: unknown[], refused: {name: string, reason: string}[], reported: string[]}} ImportedLabels */

/** Defaults of fields that a label set may omit. */
const LABEL_DEFAULTS = {
  short: '',
  aliases: [],
  shape: 'other',
  category: 'other',
  size_mm: null,
  mirror: null,
  teach: 'sign',
  colour: null,
  pinned: null,
  hidden: false,
  merged_into: null,
};
const HEAD = /** @type {const} */ ({
  key: 'string',
  name: 'string',
  version: 'number',
  labels: 'number',
  default: 'boolean',
  shipped: 'boolean',
});

/**
 * @param {string} base
 * @param {(path: string, options?: import('./http.js').RequestOptions) => Promise<any>} json
 */
export function labelRoutes(base, json) {
  return {
    /** @param {string|null} [video]   labels of its set; null: of the library's default set @param {Call} [call] @returns {Promise<import('../types.js').Label[]>} */
    labels: async (video, call) =>
      expectList('GET /labels', await json('/labels', { ...call, query: { video } }), {
        id: 'number',
        key: 'string',
        name: 'string',
        picture: 'nullable',
        aliases: 'array',
        attributes: 'array',
      }),
    /** @param {Call} [call] @returns {Promise<LabelSetHead[]>} */
    labelSets: async (call) => expectList('GET /label-sets', await json('/label-sets', call), HEAD),
    /** @param {string} set @param {Call} [call] @returns {Promise<import('../types.js').Label[]>} all labels of a set, also hidden and merged ones */
    labelsOfSet: async (set, call) => {
      const found = expectObject('GET /label-sets/…', await json(`/label-sets/${encode(set)}`, call), {
        key: 'string',
        version: 'number',
        labels: 'array',
      });
      return expectList('GET /label-sets/…', found.labels, { id: 'number', key: 'string', name: 'string' }).map((label) => ({
        ...LABEL_DEFAULTS,
        ...label,
        attributes: (label.attributes ?? []).map((/** @type {any} */ one) => ({
          mutable: false,
          values: [],
          low: null,
          high: null,
          default: null,
          ...one,
        })),
        picture: label.pictogram
          ? `${base}/labels/${label.id}.png?set=${encode(set)}&size=64&look=${encode(label.pictogram.slice(-60))}`
          : null,
      }));
    },
    /** @param {string} set @param {Call} [call] @returns {Promise<Record<string, {tracks: number, videos: number}>>} by id of the label */
    labelUsage: async (set, call) =>
      expectObject('GET /label-sets/…/usage', await json(`/label-sets/${encode(set)}/usage`, { timeout: 60_000, ...call }), {}),
    /** @param {string} set @param {Call} [call] @returns {Promise<import('../types.js').LabelVersion[]>} newest first */
    labelHistory: async (set, call) =>
      expectList('GET /label-sets/…/history', await json(`/label-sets/${encode(set)}/history`, call), {
        version: 'number',
        author: 'string',
        created: 'nullable',
        sentence: 'string',
        undoes: 'nullable',
      }),
    /** @param {string} set @param {string} format @returns {string} address of the file */
    labelFileUrl: (set, format) => `${base}/label-sets/${encode(set)}/file?format=${encode(format)}`,
    /** @param {string} set @param {string} author @param {import('../types.js').LabelChange} change @param {Call} [call] @returns {Promise<LabelAnswer>} */
    changeLabels: async (set, author, change, call) =>
      expectObject(
        'POST /label-sets/…/changes',
        await json(`/label-sets/${encode(set)}/changes`, { ...call, method: 'POST', body: { author, change } }),
        { version: 'number', label: 'nullable', sentence: 'string' },
      ),
    /** @param {string} set @param {File} file @param {string} author @param {boolean} create   make the set if it does not exist @param {Call} [call] @returns {Promise<ImportedLabels>} */
    importLabels: async (set, file, author, create, call) =>
      expectObject(
        'POST /label-sets/…/files',
        await json(`/label-sets/${encode(set)}/files`, {
          timeout: 60_000,
          ...call,
          method: 'POST',
          body: file,
          type: 'application/octet-stream',
          query: { author, name: file.name.slice(-120), create: create ? 'true' : null },
        }),
        { sentence: 'string', added: 'array', known: 'array', refused: 'array', reported: 'array' },
      ),
    /** @param {string} video @param {string|null} set   null: the library's default @param {Call} [call] @returns {Promise<unknown>} */
    useLabelSet: (video, set, call) => json(`/videos/${encode(video)}/label-set`, { ...call, method: 'PUT', body: { set } }),
    /** @param {string} set @param {Call} [call] @returns {Promise<unknown>} */
    setDefaultLabelSet: (set, call) => json('/label-sets/default', { ...call, method: 'PUT', body: { set } }),
  };
}
