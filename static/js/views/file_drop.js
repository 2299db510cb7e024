// @ts-check
/** Files dropped onto a part of the page. */

/**
 * @param {HTMLElement} target   gets the class `dropping` while files are over it
 * @param {(files: File[], event: DragEvent) => unknown} onDrop   `false`: not handled; an outer element may take them
 */
export function acceptFileDrops(target, onDrop) {
  let depth = 0;
  /** @param {DragEvent} event */
  const hasFiles = (event) => event.dataTransfer?.types.includes('Files') ?? false;
  target.addEventListener('dragenter', (event) => {
    if (!hasFiles(event)) return;
    depth += 1;
    target.classList.add('dropping');
  });
  target.addEventListener('dragleave', (event) => {
    if (!hasFiles(event)) return;
    depth -= 1;
    if (depth <= 0) target.classList.remove('dropping');
  });
  target.addEventListener('dragover', (event) => {
    if (hasFiles(event)) event.preventDefault();
  });
  target.addEventListener('drop', (event) => {
    depth = 0;
    target.classList.remove('dropping');
    if (!hasFiles(event) || event.defaultPrevented) return;
    if (onDrop([...(event.dataTransfer?.files ?? [])], event) !== false) event.preventDefault();
  });
}
