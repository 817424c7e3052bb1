"""The picture that a notebook shows, drawn by a real browser that runs no scripts."""

import steadyload as sl


def test_it_is_drawn_with_the_item_at_fault_in_red(browser, tmp_path):
    items = tuple(
        sl.Item(n, (40.0 + x, 10.0 * n, 40.0), (10, 10, 10), 1.0) for n, x in enumerate((0, 3, 9))
    )
    verdict = sl.make_method("sme").judge(sl.Layout("falls", sl.Pallet(100, 60, 100), items))
    page = tmp_path / "shown.html"
    forbidding = (
        "<meta charset='utf-8'><meta http-equiv='Content-Security-Policy' "
        "content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">"
    )
    page.write_text(forbidding + verdict._repr_html_())
    browser.errors.clear()
    browser.requests.clear()
    browser("Page.navigate", url=page.as_uri())
    size, red = browser.value(
        "(async () => {const img = await new Promise(r => {const t = () => {"
        "const i = document.querySelector('img'); i?.complete ? r(i) : setTimeout(t, 20)}; t();});"
        "const c = document.createElement('canvas'); c.width = 440; c.height = 330;"
        "const pen = c.getContext('2d'); pen.drawImage(img, 0, 0);"
        "const d = pen.getImageData(0, 0, 440, 330).data; let n = 0;"
        "for (let k = 0; k < d.length; k += 4) n += d[k] > 150 && d[k + 1] < 60 && d[k + 3] > 250;"
        "return [[img.naturalWidth, img.naturalHeight], n];})()"
    )
    assert size == [440, 330]
    assert red > 300
    assert not browser.errors
    assert all(url.startswith(("file:", "data:")) for url in browser.requests)
