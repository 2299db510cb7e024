// @ts-check
export { createPicture } from './picture/index.js';
