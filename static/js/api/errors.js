// @ts-check
/**
 * Errors of requests to the server.
 *
 * `status` 0: no answer came; `code` is then `offline`, `timeout` or `aborted`.
 */
export class ApiError extends Error {
  /**
   * @param {number} status
   * @param {string} code
   * @param {string} message   one sentence for the user
   * @param {{field?: string|null, details?: Record<string, any>|null, cause?: unknown}} [more]
   */
  constructor(status, code, message, more = {}) {
    super(message, { cause: more.cause });
    this.name = 'ApiError';
    this.status = status;
    this.code = code;
    this.field = more.field ?? null;
    /** @type {Record<string, any>} */
    this.details = more.details ?? {};
  }

  /** Whether the same request may succeed later. A repetition does no harm. */
  get isTemporary() {
    return this.status === 0 ? this.code !== 'aborted' : this.status === 503 || this.status === 507;
  }
}

/** Whether a failed request may succeed if it is repeated. @param {unknown} thrown @returns {thrown is ApiError} */
export const isRetryable = (thrown) => thrown instanceof ApiError && thrown.isTemporary;

/**
 * The error of an answer that is not 2xx.
 *
 * @param {number} status
 * @param {string} text   the body
 * @returns {ApiError}
 */
export function errorFromResponse(status, text) {
  try {
    const { error } = JSON.parse(text);
    if (typeof error.code === 'string' && typeof error.message === 'string') {
      return new ApiError(status, error.code, error.message, { field: error.field, details: error.details });
    }
  } catch {
    // Not from tsr but, for example, from a proxy. The sentence below says so.
  }
  // A proxy says that it did not reach the server, or got no answer.
  if (status === 502 || status === 503) return offlineError();
  if (status === 504) return timeoutError();
  return new ApiError(
    status,
    'bad_answer',
    `The server answered ${status} without saying why. Try again. If it keeps failing, look at the terminal in which the server runs.`,
  );
}

/** The error of a request that got no answer. @param {unknown} cause @returns {ApiError} */
export function toApiError(cause) {
  const name = cause instanceof Error ? cause.name : '';
  if (cause instanceof ApiError) return cause;
  if (name === 'AbortError') return new ApiError(0, 'aborted', 'The request was cancelled.', { cause });
  return name === 'TimeoutError' ? timeoutError(cause) : offlineError(cause);
}

/** @param {unknown} [cause] @returns {ApiError} */
function timeoutError(cause) {
  return new ApiError(0, 'timeout', 'The server did not answer in time. It may be busy; try again.', { cause });
}

/** @param {unknown} [cause] @returns {ApiError} */
function offlineError(cause) {
  return new ApiError(0, 'offline', 'The server cannot be reached. Check in its terminal whether it still runs.', { cause });
}

/** A sentence for the user about anything that was thrown. @param {unknown} thrown @returns {string} */
export function errorMessage(thrown) {
  return thrown instanceof ApiError ? thrown.message : 'Something in the page went wrong. Reload it; saved work is not lost.';
}
