// @ts-check
// On a phone the panel is a sheet at the bottom: pulled up it shows everything, down only the result and the height.

const panel = htmlById("panel");
const sheetHandle = buttonById("sheet-handle");

/** @param {boolean} isOpen */
function openSheet(isOpen) {
  panel.classList.toggle("open", isOpen);
  sheetHandle.setAttribute("aria-expanded", String(isOpen));
  if (!isOpen) panel.scrollTop = 0;
}

/** Closed, the sheet ends below the height; what stands above it depends on language and layer. */
function fitSheet() {
  const { offsetTop, offsetHeight } = htmlById("height-box");
  if (!panel.classList.contains("open")) document.body.style.setProperty("--peek", `${offsetTop + offsetHeight}px`);
}

function listenToSheet() {
  const fit = new ResizeObserver(fitSheet);
  for (const id of ["result", "height-box"]) fit.observe(htmlById(id));
  /** @type {number | null} */
  let from = null;
  sheetHandle.addEventListener("pointerdown", (event) => {
    from = event.clientY;
    sheetHandle.setPointerCapture(event.pointerId);
  });
  sheetHandle.addEventListener("pointerup", (event) => {
    if (from === null) return;
    const pulled = from - event.clientY;
    from = null;
    // A pull opens or closes by its direction; a tap turns over, in the click that follows.
    if (Math.abs(pulled) > 12) {
      openSheet(pulled > 0);
      sheetHandle.dataset.pulled = "true";
    }
  });
  sheetHandle.addEventListener("click", () => {
    if (sheetHandle.dataset.pulled) delete sheetHandle.dataset.pulled;
    else openSheet(!panel.classList.contains("open"));
  });
}
