// @ts-check
/**
 * The shared time axis: frames to pixels, zoom and pan within the drive, and ticks. Pure.
 *
 * @typedef {{first: number, last: number}} Span   frames; may be fractional; `last` is exclusive
 */

/** Minimum number of frames on the axis. */
export const MIN_FRAMES = 8;
const STEPS = [1, 2, 5];

/** @param {Span} span @param {number} frame @param {number} width @returns {number} px of the left edge of a frame */
export function toX(span, frame, width) {
  return ((frame - span.first) / (span.last - span.first)) * width;
}

/** @param {Span} span @param {number} x @param {number} width @returns {number} fractional frame */
export function toFrame(span, x, width) {
  return span.first + (x / Math.max(1, width)) * (span.last - span.first);
}

/**
 * Zoom so that the frame under the pointer stays under it.
 *
 * @param {Span} span
 * @param {number} frame    the frame under the pointer
 * @param {number} factor   < 1 zooms in
 * @param {number} frames   of the drive
 * @returns {Span}
 */
export function zoomAround(span, frame, factor, frames) {
  const length = Math.min(Math.max((span.last - span.first) * factor, Math.min(MIN_FRAMES, frames)), Math.max(1, frames));
  const share = (frame - span.first) / (span.last - span.first);
  return clampSpan(frame - share * length, length, frames);
}

/** @param {Span} span @param {number} by   frames @param {number} frames @returns {Span} */
export function panBy(span, by, frames) {
  return clampSpan(span.first + by, span.last - span.first, frames);
}

/**
 * Move the span if a frame is outside it, keeping its length.
 *
 * @param {Span} span
 * @param {number} frame
 * @param {number} frames
 * @returns {Span} the same object if the frame is visible
 */
export function reveal(span, frame, frames) {
  if (frame >= span.first && frame + 1 <= span.last) return span;
  const length = span.last - span.first;
  return clampSpan(frame - length * (frame < span.first ? 0.9 : 0.1), length, frames);
}

/** @param {number} first @param {number} last   inclusive @param {number} frames @returns {Span} with margins on both sides */
export function spanAround(first, last, frames) {
  const length = Math.min(Math.max((last - first + 1) * 1.3, MIN_FRAMES * 4), Math.max(1, frames));
  return clampSpan((first + last + 1 - length) / 2, length, frames);
}

/**
 * Frames between two ticks.
 *
 * @param {number} framesPerPixel
 * @param {number} labelWidth   width of a label, px
 * @returns {number} 1, 2 or 5 times a power of ten
 */
export function tickStep(framesPerPixel, labelWidth) {
  const minStep = Math.max(1, framesPerPixel * labelWidth);
  const power = 10 ** Math.floor(Math.log10(minStep));
  for (const step of STEPS) if (step * power >= minStep) return step * power;
  return 10 * power;
}

/**
 * A time label for the axis, with as many digits as the distance of ticks requires.
 *
 * @param {number} seconds
 * @param {number} tickInterval   seconds between two ticks
 * @returns {string} `1:02:03`, `2:03.4`
 */
export function timeLabel(seconds, tickInterval) {
  const digits = tickInterval >= 1 ? 0 : tickInterval >= 0.1 ? 1 : tickInterval >= 0.01 ? 2 : 3;
  const unit = 10 ** digits;
  const ticks = Math.round(Math.max(0, seconds) * unit);
  const whole = Math.floor(ticks / unit);
  const rest = digits > 0 ? `.${String(ticks % unit).padStart(digits, '0')}` : '';
  const hours = Math.floor(whole / 3600);
  const minutes = String(Math.floor(whole / 60) % 60).padStart(hours > 0 ? 2 : 1, '0');
  return `${hours > 0 ? `${hours}:` : ''}${minutes}:${String(whole % 60).padStart(2, '0')}${rest}`;
}

/** @param {number} start @param {number} length @param {number} frames @returns {Span} */
function clampSpan(start, length, frames) {
  const size = Math.min(length, Math.max(1, frames));
  const first = Math.min(Math.max(0, start), Math.max(0, frames - size));
  return { first, last: first + size };
}
