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

const CLICK = 4;

/**
 * @param {HTMLElement} element
 * @param {'seek'|'pan'} drag   effect of a drag with the main button
 * @param {GestureTarget} target
 * @param {AbortSignal} signal
 */
export function attachGestures(element, drag, target, signal) {
  /** @type {Map<number, number>} */
  const down = new Map();
  let moved = 0;
  let mode = drag;
  /** @param {PointerEvent|WheelEvent} event */
  const place = (event) => event.clientX - element.getBoundingClientRect().left;

  element.addEventListener(
    'pointerdown',
    (event) => {
      if (event.button > 1) return;
      event.preventDefault();
      element.setPointerCapture(event.pointerId);
      down.set(event.pointerId, place(event));
      moved = 0;
      mode = event.button === 1 ? 'pan' : drag;
      if (event.button === 0 && down.size === 1 && drag === 'seek') {
        target.press?.(place(event), event.clientY - element.getBoundingClientRect().top);
        target.seek(place(event));
      }
    },
    { signal },
  );

  element.addEventListener(
    'pointermove',
    (event) => {
      const x = place(event);
      const old = down.get(event.pointerId);
      target.hover?.(x);
      if (old === undefined) return;
      moved += Math.abs(x - old);
      if (down.size === 2) {
        const other = [...down.entries()].find(([id]) => id !== event.pointerId)?.[1] ?? x;
        const factor = Math.max(8, Math.abs(old - other)) / Math.max(8, Math.abs(x - other));
        target.zoom(other, factor);
      } else if (mode === 'seek') target.seek(x);
      else target.pan(old, x);
      down.set(event.pointerId, x);
    },
    { signal },
  );

  /** @param {PointerEvent} event */
  const up = (event) => {
    const was = down.delete(event.pointerId);
    if (was && event.type === 'pointerup' && mode === 'pan' && event.button === 0 && moved < CLICK) target.seek(place(event));
  };
  element.addEventListener('pointerup', up, { signal });
  element.addEventListener('pointercancel', up, { signal });
  element.addEventListener('pointerleave', () => target.hover?.(null), { signal });

  element.addEventListener(
    'wheel',
    (event) => {
      if (event.altKey) return;
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 16 : 1;
      const dx = event.deltaX * lines;
      const dy = event.deltaY * lines;
      if (event.shiftKey || Math.abs(dx) > Math.abs(dy)) target.pan(Math.abs(dx) > Math.abs(dy) ? dx : dy, 0);
      else target.zoom(place(event), Math.exp(Math.max(-120, Math.min(120, dy)) * (event.ctrlKey ? 0.01 : 0.0025)));
    },
    { passive: false, signal },
  );
}
