// Lets the search work from disk, where browsers start no worker: a hidden frame runs the worker's script instead.
// The theme's plugin "offline" would fetch such a script; it takes this one, which has its name (mkdocs.yml).
if (location.protocol === "file:") {
  window.Worker = class FrameWorker extends EventTarget {
    constructor(url) {
      super();
      this.frame = document.createElement("iframe");
      this.frame.hidden = true;
      const script = document.createElement("script");
      script.src = url;
      this.frame.srcdoc = script.outerHTML;
      this.loaded = new Promise((loaded) => this.frame.addEventListener("load", loaded, { once: true })).then(() => {
        const scope = this.frame.contentWindow;
        scope.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
        return scope;
      });
      document.body.append(this.frame);
    }
    postMessage(data) {
      this.loaded.then((scope) => scope.dispatchEvent(new MessageEvent("message", { data })));
    }
    terminate() {
      this.frame.remove();
    }
  };
}
