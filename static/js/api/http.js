// @ts-check
/** One request: time limit, cancellation, and every failure as an `ApiError`. */

import { ApiError, errorFromResponse, toApiError } from './errors.js';

/**
 * @typedef {object} RequestOptions
 * @property {string} [method]
 * @property {any} [body]                sent as JSON, unless it is a Blob or text
 * @property {string} [type]             media type of a Blob or text body
 * @property {Record<string, string>} [headers]
 * @property {Record<string, string|number|null|undefined>} [query]   null and undefined are omitted
 * @property {AbortSignal} [signal]
 * @property {number} [timeout]          ms; default 20,000
 */

/** @typedef {(path: string, options?: RequestOptions) => Promise<Response>} Send */
/** @typedef {{base: string, send: Send, json: (path: string, options?: RequestOptions) => Promise<any>}} Routes   what the routes are built with; base: prefix of every path */

/**
 * @param {{base: string, fetch: typeof fetch, signal?: AbortSignal}} setup
 * @returns {Send} resolves only for 2xx
 */
export function createSend({ base, fetch, signal: pageSignal }) {
  return async (path, options = {}) => {
    const signals = [AbortSignal.timeout(options.timeout ?? 20_000)];
    if (options.signal) signals.push(options.signal);
    if (pageSignal) signals.push(pageSignal);
    const headers = new Headers(options.headers);
    let body = options.body;
    if (body !== undefined && typeof body !== 'string' && !(body instanceof Blob)) {
      body = JSON.stringify(body);
      headers.set('Content-Type', 'application/json');
    } else if (options.type) {
      headers.set('Content-Type', options.type);
    }
    const request = {
      method: options.method ?? 'GET',
      headers,
      body,
      signal: AbortSignal.any(signals),
      credentials: /** @type {const} */ ('same-origin'),
    };
    /** @type {Response} */
    let answer;
    try {
      answer = await fetch(base + path + queryText(options.query), request);
      if (answer.ok) return answer;
      throw errorFromResponse(answer.status, await answer.text());
    } catch (cause) {
      throw toApiError(cause);
    }
  };
}

/**
 * Parse the JSON of an answer.
 *
 * @param {Response} answer
 * @returns {Promise<any>} undefined for 204
 */
export async function readJson(answer) {
  if (answer.status === 204) return undefined;
  try {
    return await answer.json();
  } catch (cause) {
    if (!(cause instanceof SyntaxError)) throw toApiError(cause);
    const message = 'The answer is not from the review tool, but perhaps from a proxy in between. Reload the page.';
    throw new ApiError(0, 'bad_answer', message, { cause });
  }
}

/** A text as a part of a path. @param {string} part */
export const encode = (part) => encodeURIComponent(part);

/**
 * @param {RequestOptions['query']} query
 * @returns {string} `?a=1&b=2`, or an empty string
 */
export function queryText(query) {
  const pairs = Object.entries(query ?? {}).filter(([, value]) => value !== null && value !== undefined);
  return pairs.length ? `?${new URLSearchParams(pairs.map(([name, value]) => [name, String(value)]))}` : '';
}
