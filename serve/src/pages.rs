//! Static files of the server, and short pages with refusals.

use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};

use views::gantt;
use views::xml::escaped;

/// Returns a file of `/static/`; `None` if there is no such file.
pub fn file(name: &str) -> Option<Response> {
    let (kind, text) = match name {
        "page.css" => ("text/css; charset=utf-8", include_str!("assets/page.css")),
        "icon.svg" => ("image/svg+xml", include_str!("assets/icon.svg")),
        "plan.css" => ("text/css; charset=utf-8", gantt::STYLE),
        "common.js" => ("text/javascript; charset=utf-8", include_str!("assets/common.js")),
        "map.js" => ("text/javascript; charset=utf-8", include_str!("assets/map.js")),
        "reminder.js" => ("text/javascript; charset=utf-8", include_str!("assets/reminder.js")),
        "person.js" => ("text/javascript; charset=utf-8", include_str!("assets/person.js")),
        "supervisor.js" => ("text/javascript; charset=utf-8", include_str!("assets/supervisor.js")),
        _ => return None,
    };
    Some(([(header::CONTENT_TYPE, HeaderValue::from_static(kind))], text).into_response())
}

/// Returns the page of a person.
pub fn person() -> Response {
    html(StatusCode::OK, include_str!("assets/person.html").to_string())
}

/// Returns the page of the supervisor.
pub fn supervisor() -> Response {
    html(StatusCode::OK, include_str!("assets/supervisor.html").to_string())
}

/// Returns the page of an unused link. Only its button uses the link, since messengers prefetch links for previews.
pub fn invitation(mission: &str, name: &str) -> Response {
    let title = format!("{name}: {mission}");
    let (mission, name) = (escaped(mission), escaped(name));
    html(
        StatusCode::OK,
        short(
            &title,
            &format!(
                "<p class=\"big\">This is the page of {name} in the mission {mission}.</p>\n\
                 <p>The link opens once, on one device. Open it only if you are {name}.</p>\n\
                 <form method=\"post\"><button class=\"main\" id=\"open\">Open my page</button></form>"
            ),
        ),
    )
}

/// Returns the page of a used link; `page` is the path of the session that it created.
pub fn used(page: &str) -> Response {
    html(
        StatusCode::GONE,
        short(
            "This link has been used",
            &format!(
                "<p class=\"big\">This link has been used.</p>\n\
                 <p>A link opens once. If it was you, on this device, <a href=\"{}\">go to your page</a>. If not, \
                 somebody else has opened it: ask the supervisor for a new link, which ends what the old one opened.</p>",
                escaped(page)
            ),
        ),
    )
}

/// Returns a page with the reason for a refusal.
pub fn refusal(status: StatusCode, title: &str, why: &str) -> Response {
    let (shown, why) = (escaped(title), escaped(why));
    html(status, short(title, &format!("<p class=\"big\">{shown}</p>\n<p>{why}</p>")))
}

fn short(title: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n\
         <link rel=\"icon\" href=\"/static/icon.svg\">\n<link rel=\"stylesheet\" href=\"/static/page.css\">\n</head>\n<body>\n<section>\n{body}\n</section>\n</body>\n</html>\n",
        escaped(title)
    )
}

fn html(status: StatusCode, text: String) -> Response {
    (status, [(header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8"))], text).into_response()
}
