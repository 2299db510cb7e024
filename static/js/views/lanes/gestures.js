// @ts-check
/** Pointer and wheel on the lanes: seek, pan, zoom, pinch. Independent of tracks. */

/**
 * @typedef {object} GestureTarget
 * @property {(x: number) => void} seek                       x: px in the plot
 * @property {(from: number, to: number) => void} pan         the point under `from` moves to `to`
 * @property {(x: number, factor: number) => void} zoom       factor < 1 zooms in
 * @property {(x: number, y: number) => void} [press]         pointer down, before it seeks
 * @property {(x: number|null) => void} [hover]
 */

const MAX_CLICK_MOVE_PX = 4;

/**
 * Take the focus out of a field, as a press elsewhere does. A cancelled `pointerdown` leaves it there: later keys would
 * go into the field, and its change would count for the track that is selected next.
 */
export function leaveField() {
  const { activeElement } = document;
  if (activeElement instanceof HTMLElement && activeElement.matches('input, textarea, select')) activeElement.blur();
}

/**
 * @param {HTMLElement} element
 * @param {'seek'|'pan'} drag   effect of a drag with the main button
 * @param {GestureTarget} target
 */
export function attachGestures(element, drag, target) {
  /** @type {Map<number, number>} */ const pointers = new Map();
  let movedPx = 0;
  let mode = drag;
  /** @param {PointerEvent|WheelEvent} event */
  const xOf = (event) => event.clientX - element.getBoundingClientRect().left;

  element.addEventListener('pointerdown', (event) => {
    if (event.button > 1) return;
    event.preventDefault();
    leaveField();
    element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, xOf(event));
    movedPx = 0;
    mode = event.button === 1 ? 'pan' : drag;
    if (event.button === 0 && pointers.size === 1 && drag === 'seek') {
      target.press?.(xOf(event), event.clientY - element.getBoundingClientRect().top);
      target.seek(xOf(event));
    }
  });

  element.addEventListener('pointermove', (event) => {
    const x = xOf(event);
    const oldX = pointers.get(event.pointerId);
    target.hover?.(x);
    if (oldX === undefined) return;
    movedPx += Math.abs(x - oldX);
    if (pointers.size === 2) {
      const other = [...pointers.entries()].find(([id]) => id !== event.pointerId)?.[1] ?? x;
      const factor = Math.max(8, Math.abs(oldX - other)) / Math.max(8, Math.abs(x - other));
      target.zoom(other, factor);
    } else if (mode === 'seek') target.seek(x);
    else target.pan(oldX, x);
    pointers.set(event.pointerId, x);
  });

  /** @param {PointerEvent} event */
  const onPointerUp = (event) => {
    const wasDown = pointers.delete(event.pointerId);
    if (wasDown && event.type === 'pointerup' && mode === 'pan' && event.button === 0 && movedPx < MAX_CLICK_MOVE_PX)
      target.seek(xOf(event));
  };
  element.addEventListener('pointerup', onPointerUp);
  element.addEventListener('pointercancel', onPointerUp);
  element.addEventListener('pointerleave', () => target.hover?.(null));

  element.addEventListener(
    'wheel',
    (event) => {
      if (event.altKey) return;
      event.preventDefault();
      const pxPerLine = event.deltaMode === 1 ? 16 : 1;
      const dx = event.deltaX * pxPerLine;
      const dy = event.deltaY * pxPerLine;
      if (event.shiftKey || Math.abs(dx) > Math.abs(dy)) target.pan(Math.abs(dx) > Math.abs(dy) ? dx : dy, 0);
      else target.zoom(xOf(event), Math.exp(Math.max(-120, Math.min(120, dy)) * (event.ctrlKey ? 0.01 : 0.0025)));
    },
    { passive: false },
  );
}
