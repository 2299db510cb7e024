// @ts-check
/** Pictures of labels, as PNG for a label set. */

/** Longest side of a picture of a label, px. */
const MAX_SIDE_PX = 256;

/**
 * @param {Blob} file   a picture
 * @param {import('../types.js').Box} [box]   the part to use, px; default: the whole picture
 * @returns {Promise<string>} PNG, base64
 * @throws {DOMException} the browser cannot read it as a picture
 */
export async function toPngBase64(file, box) {
  const image = await createImageBitmap(file);
  const [x1, y1, x2, y2] = box
    ? [
        Math.max(0, Math.floor(box[0])),
        Math.max(0, Math.floor(box[1])),
        Math.min(image.width, Math.ceil(box[2])),
        Math.min(image.height, Math.ceil(box[3])),
      ]
    : [0, 0, image.width, image.height];
  const [width, height] = [Math.max(1, x2 - x1), Math.max(1, y2 - y1)];
  const scale = Math.min(1, MAX_SIDE_PX / Math.max(width, height));
  const canvas = document.createElement('canvas');
  [canvas.width, canvas.height] = [Math.max(1, Math.round(width * scale)), Math.max(1, Math.round(height * scale))];
  const ctx = canvas.getContext('2d');
  if (!ctx) throw new DOMException('This browser has no canvas.');
  ctx.drawImage(image, x1, y1, width, height, 0, 0, canvas.width, canvas.height);
  image.close();
  return canvas.toDataURL('image/png').split(',')[1];
}
