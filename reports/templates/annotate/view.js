// The picture on the page: zoom, pan and touch, and where a pixel of the film lies on the screen. Draws nothing itself.
class PictureView {
  // `draw(context, view)` draws over the picture. `pointer` has down(pixel, event), move(pixel, event), up(), cancel(),
  // click(pixel, event) and hover(pixel). down returns true where it takes hold of something; else the picture is moved with
  // the pointer, or it was a click.
  constructor(box, picture, drawing, draw, pointer) {
    Object.assign(this, {box, picture, drawing, draw, pointer, image: null, zoom: 1, left: 0, top: 0, contrast: 1});
    this.pointers = new Map();
    this.taken = false;
    new ResizeObserver(() => this.resize()).observe(box);
    box.addEventListener("pointerdown", event => this.#down(event));
    box.addEventListener("pointermove", event => this.#move(event));
    for (const end of ["pointerup", "pointercancel"]) box.addEventListener(end, event => this.#up(event));
    box.addEventListener("wheel", event => {
      event.preventDefault();
      this.zoomBy(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.06 : 0.002)), this.#at(event));
    }, {passive: false});
  }

  get size() { return [this.box.clientWidth, this.box.clientHeight]; }
  // From a pixel of the film (integers at pixel centres) to the screen, and back
  toScreen([column, row]) { return [(column + 0.5 - this.left) * this.zoom, (row + 0.5 - this.top) * this.zoom]; }
  toPixel([x, y]) { return [x / this.zoom + this.left - 0.5, y / this.zoom + this.top - 0.5]; }

  show(image) {
    const isNew = !this.image || this.image.naturalWidth !== image.naturalWidth || this.image.naturalHeight !== image.naturalHeight;
    this.image = image;
    if (isNew) this.fit();
    this.refresh();
  }
  fit() {
    if (!this.image) return;
    const [width, height] = this.size, {naturalWidth, naturalHeight} = this.image;
    this.fitted = true;
    this.zoom = Math.min(width / naturalWidth, height / naturalHeight) || 1;
    this.left = (naturalWidth - width / this.zoom) / 2;
    this.top = (naturalHeight - height / this.zoom) / 2;
    this.refresh();
  }
  zoomBy(factor, about = this.size.map(length => length / 2)) {
    const before = this.toPixel(about);
    this.zoom = Math.min(60, Math.max(0.05, this.zoom * factor));
    this.fitted = false;
    const after = this.toPixel(about);
    this.left += before[0] - after[0];
    this.top += before[1] - after[1];
    this.refresh();
  }
  panBy(x, y) {  // screen pixels
    this.left -= x / this.zoom;
    this.top -= y / this.zoom;
    this.fitted = false;
    this.refresh();
  }
  resize() {
    const ratio = window.devicePixelRatio || 1;
    for (const canvas of [this.picture, this.drawing]) {
      canvas.width = Math.round(this.box.clientWidth * ratio);
      canvas.height = Math.round(this.box.clientHeight * ratio);
    }
    if (this.fitted) this.fit(); else this.refresh();
  }
  refresh() {
    if (this.pending) return;
    this.pending = requestAnimationFrame(() => {
      this.pending = 0;
      const ratio = window.devicePixelRatio || 1, [width, height] = this.size;
      const contexts = [this.picture, this.drawing].map(canvas => canvas.getContext("2d"));
      for (const context of contexts) {
        context.setTransform(ratio, 0, 0, ratio, 0, 0);
        context.clearRect(0, 0, width, height);
      }
      if (!this.image) return;
      contexts[0].imageSmoothingEnabled = this.zoom < 3;
      const {naturalWidth, naturalHeight} = this.image;
      contexts[0].drawImage(this.image, -this.left * this.zoom, -this.top * this.zoom, naturalWidth * this.zoom, naturalHeight * this.zoom);
      this.picture.style.filter = this.contrast === 1 ? "" : `contrast(${this.contrast})`;
      this.draw(contexts[1], this);
    });
  }

  #at(event) {
    const box = this.box.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }
  #down(event) {
    if (event.button > 1) return;
    event.preventDefault();
    this.box.focus({preventScroll: true});
    this.box.setPointerCapture(event.pointerId);
    const at = this.#at(event);
    this.pointers.set(event.pointerId, at);
    if (this.pointers.size === 1) this.travelled = 0;
    // A second finger pinches; what the first one began is given up
    if (this.pointers.size > 1) {
      if (this.taken) this.pointer.cancel();
      this.taken = false;
      this.travelled = Infinity;
      return;
    }
    this.taken = event.button === 0 && this.pointer.down(this.toPixel(at), event);
  }
  #move(event) {
    const at = this.#at(event), before = this.pointers.get(event.pointerId);
    if (!before) return this.pointer.hover(this.toPixel(at));
    this.travelled += Math.hypot(at[0] - before[0], at[1] - before[1]);
    if (this.pointers.size === 2) {
      const other = [...this.pointers].find(([id]) => id !== event.pointerId)[1];
      const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
      this.panBy((at[0] - before[0]) / 2, (at[1] - before[1]) / 2);
      this.zoomBy(distance(at, other) / Math.max(1, distance(before, other)), [(at[0] + other[0]) / 2, (at[1] + other[1]) / 2]);
    } else if (this.taken) {
      this.pointer.move(this.toPixel(at), event);
    } else if (this.travelled > (event.pointerType === "touch" ? 10 : 4)) {
      this.panBy(at[0] - before[0], at[1] - before[1]);
    }
    this.pointers.set(event.pointerId, at);
  }
  #up(event) {
    if (!this.pointers.delete(event.pointerId)) return;
    if (this.taken) this.pointer.up();
    else if (event.type === "pointerup" && event.button === 0 && this.travelled <= (event.pointerType === "touch" ? 10 : 4))
      this.pointer.click(this.toPixel(this.#at(event)), event);
    this.taken = false;
  }
}
